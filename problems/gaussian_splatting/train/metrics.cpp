#include "problems/gaussian_splatting/train/metrics.h"

#include "kernels/image/metrics.h"

namespace vesta::gs {

double NearPlane(const Scene& scene) { return 0.01 * scene.extent; }

splat::PinholeView ToPinhole(const View& view, double near) {
  splat::PinholeView pinhole{};
  std::copy(view.rotation.begin(), view.rotation.end(), pinhole.R);
  std::copy(view.translation.begin(), view.translation.end(), pinhole.T);
  const auto centre = CameraCenter(view);
  std::copy(centre.begin(), centre.end(), pinhole.centre);
  pinhole.fx = view.camera.fx, pinhole.fy = view.camera.fy;
  pinhole.cx = view.camera.cx, pinhole.cy = view.camera.cy;
  pinhole.width = view.camera.width, pinhole.height = view.camera.height;
  pinhole.near = near;
  return pinhole;
}

splat::Model<float> ToKernelModel(const SplatModel& model) {
  return {model.data.data(), model.count, model.sh_degree, model.sh_degree};
}

void Renderer::RenderInto(const splat::Model<float>& model, const View& view, Image& image) {
  splats_.Build(model, ToPinhole(view, near_), background_.data(), workspace_);
  if (image.width != view.camera.width || image.height != view.camera.height) {
    image = Image(view.camera.width, view.camera.height);
  }
  splats_.Render(image.rgb.data());
}

Image Renderer::Render(const SplatModel& model, const View& view) {
  Image image;
  RenderInto(ToKernelModel(model), view, image);
  return image;
}

Evaluation Renderer::Evaluate(const SplatModel& model, const Scene& scene) {
  return Evaluate(ToKernelModel(model), scene);
}

Evaluation Renderer::Evaluate(const splat::Model<float>& model, const Scene& scene) {
  Evaluation result;
  ImageQualityMeter meter;
  PhotometricLoss<float> loss;
  Image image;
  double cost = 0, values = 0;
  for (const View& view : scene.views) {
    RenderInto(model, view, image);
    const ImageShape shape{image.width, image.height};
    const HostSpan<const float> rendered(image.rgb.data(), shape.NumValues());
    const HostSpan<const float> truth(view.image.rgb.data(), shape.NumValues());
    const ImageQuality quality = meter.Measure(rendered, truth, shape);
    Quality& sum = view.is_test ? result.test : result.train;
    sum.psnr += quality.psnr;
    sum.ssim += quality.ssim;
    ++sum.views;
    if (!view.is_test) {
      cost += loss.Evaluate(rendered, truth, shape).objective;
      values += static_cast<double>(shape.NumValues());
    }
  }
  for (Quality* quality : {&result.train, &result.test}) {
    if (quality->views == 0) continue;
    quality->psnr /= quality->views;
    quality->ssim /= quality->views;
  }
  result.cost = values > 0 ? cost / values : 0;
  return result;
}

}  // namespace vesta::gs
