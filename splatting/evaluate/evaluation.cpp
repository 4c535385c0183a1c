// SPDX-License-Identifier: Apache-2.0
#include "splatting/evaluate/evaluation.h"

namespace vesta::gs {

Image ToCompare(Image rendered, const Image& photograph) {
  const HostSpan<float> values(rendered.rgb.data(), static_cast<Index>(rendered.rgb.size()));
  ShowLeftOut<CpuBackend<float>>(MaskOf(photograph), ValuesOf(photograph), values);
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

}  // namespace vesta::gs
