// SPDX-License-Identifier: Apache-2.0
#include "splatting/evaluate/evaluation.h"

#include <algorithm>
#include <limits>

#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {

Image ToCompare(Image rendered, const Image& photograph) {
  const HostSpan<float> values(rendered.rgb.data(), static_cast<Index>(rendered.rgb.size()));
  FillMasked<CpuBackend<float>>(MaskOf(photograph), ValuesOf(photograph), values);
  return rendered;
}

Image Renderer::Render(const SplatModel& model, const View& view) {
  Image image(view.camera.width, view.camera.height);
  splats_.Build(ToKernelModel(model), ToPosedCamera(view, near_), background_.data(), workspace_);
  splats_.Render(image.rgb.data());
  return image;
}

Evaluation Renderer::Evaluate(const SplatModel& model, const Scene& scene) {
  return Evaluate(ToKernelModel(model), scene);
}

Evaluation Renderer::Evaluate(const splat::Model<float>& model, const Scene& scene, const MeasuredViews& measured) {
  return gs::Evaluate<CpuBackend<float>>(scene, background_, {}, model, workspace_, measured);
}

ViewQuality QualityOf(std::size_t view, const Image& photograph, const ImageQuality& whole, double objective) {
  const double part = UnmaskedFraction(photograph);
  return {view, photograph.mask.empty() ? whole : QualityOfMaskedImage(whole, part), part, objective};
}

Evaluation MeanOf(const std::vector<View>& views, std::vector<ViewQuality> measured) {
  std::ranges::sort(measured, {}, &ViewQuality::view);
  Evaluation mean;
  double values = 0;
  for (const ViewQuality& of : measured) {
    const View& view = views[of.view];
    Quality& of_kind = view.is_trained() ? mean.train : view.is_test() ? mean.test : mean.held_out;
    of_kind.psnr += of.quality.psnr;
    of_kind.ssim += of.quality.ssim;
    ++of_kind.views;
    if (!view.is_trained()) continue;
    mean.cost += of.objective;
    values += of.counted * 3.0 * view.camera.width * view.camera.height;
  }
  for (Quality* quality : {&mean.train, &mean.held_out, &mean.test}) {
    if (quality->views == 0) continue;
    quality->psnr /= quality->views;
    quality->ssim /= quality->views;
  }
  // 0 dB would look like a measurement. Nothing prints held_out.
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (Quality* quality : {&mean.train, &mean.test}) {
    if (quality->views == 0) quality->psnr = quality->ssim = kUnknown;
  }
  mean.cost = values > 0 ? mean.cost / values : kUnknown;
  return mean;
}

}  // namespace vesta::gs
