#include "problems/gaussian_splatting/evaluate/metrics.h"

namespace vesta::gs {

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
  EvaluationSum sum;
  ImageQualityMeter meter;
  PhotometricLoss<float> loss;
  Image image;
  for (const View& view : scene.views) {
    RenderInto(model, view, image);
    const ImageShape shape{image.width, image.height};
    const HostSpan<const float> rendered(image.rgb.data(), shape.NumValues());
    const HostSpan<const float> truth(view.image.rgb.data(), shape.NumValues());
    const double objective = view.is_test ? 0 : loss.Evaluate(rendered, truth, shape).objective;
    sum.Add(view, meter.Measure(rendered, truth, shape), objective);
  }
  return sum.Mean();
}

void EvaluationSum::Add(const View& view, const ImageQuality& quality, double objective) {
  Quality& of_kind = view.is_test ? sum_.test : sum_.train;
  of_kind.psnr += quality.psnr;
  of_kind.ssim += quality.ssim;
  ++of_kind.views;
  if (view.is_test) return;
  sum_.cost += objective;
  values_ += 3.0 * view.camera.width * view.camera.height;
}

Evaluation EvaluationSum::Mean() const {
  Evaluation mean = sum_;
  for (Quality* quality : {&mean.train, &mean.test}) {
    if (quality->views == 0) continue;
    quality->psnr /= quality->views;
    quality->ssim /= quality->views;
  }
  mean.cost = values_ > 0 ? sum_.cost / values_ : 0;
  return mean;
}

}  // namespace vesta::gs
