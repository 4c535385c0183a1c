#include "problems/gaussian_splatting/evaluate/metrics.h"

#include <limits>

#include "problems/gaussian_splatting/evaluate/evaluation.h"

namespace vesta::gs {

Image Renderer::Render(const SplatModel& model, const View& view) {
  Image image(view.camera.width, view.camera.height);
  splats_.Build(ToKernelModel(model), ToPosedCamera(view, near_), background_.data(), workspace_);
  splats_.Render(image.rgb.data());
  return image;
}

Evaluation Renderer::Evaluate(const SplatModel& model, const Scene& scene) {
  return Evaluate(ToKernelModel(model), scene);
}

Evaluation Renderer::Evaluate(const splat::Model<float>& model, const Scene& scene) {
  return gs::Evaluate<CpuBackend<float>>(scene, background_, {}, model, workspace_);
}

void EvaluationSum::Add(const View& view, const Image& photograph, const ImageQuality& whole, double objective) {
  const double part = CountedPart(photograph);
  const ImageQuality quality = photograph.mask.empty() ? whole : OfPart(whole, part);
  Quality& of_kind = view.is_trained() ? sum_.train : view.is_test() ? sum_.test : sum_.held_out;
  of_kind.psnr += quality.psnr;
  of_kind.ssim += quality.ssim;
  ++of_kind.views;
  if (!view.is_trained()) return;
  sum_.cost += objective;
  values_ += part * 3.0 * view.camera.width * view.camera.height;
}

Evaluation EvaluationSum::Mean() const {
  Evaluation mean = sum_;
  for (Quality* quality : {&mean.train, &mean.held_out, &mean.test}) {
    if (quality->views == 0) continue;
    quality->psnr /= quality->views;
    quality->ssim /= quality->views;
  }
  // A scene may be without test views: nothing was measured then, which is not 0 dB.
  if (mean.test.views == 0) mean.test.psnr = mean.test.ssim = std::numeric_limits<double>::quiet_NaN();
  mean.cost = values_ > 0 ? sum_.cost / values_ : 0;
  return mean;
}

}  // namespace vesta::gs
