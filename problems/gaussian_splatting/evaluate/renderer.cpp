#include "problems/gaussian_splatting/evaluate/renderer.h"

#include "problems/gaussian_splatting/evaluate/evaluation.h"

namespace vesta::gs {

Image Renderer::Render(const SplatModel& model, const View& view) {
  Image image(view.camera.width, view.camera.height);
  splats_.Build(ToKernelModel(model), ToPosedCamera(view, near_), background_.data(), workspace_);
  splats_.Render(image.rgb.data());
  return image;
}

Image Renderer::RenderToCompare(const SplatModel& model, const View& view, const Image& photograph) {
  Image image = Render(model, view);
  ShowLeftOut<CpuBackend<float>>(MaskOf(photograph), ValuesOf(photograph),
                                 HostSpan<float>(image.rgb.data(), static_cast<Index>(image.rgb.size())));
  return image;
}

Evaluation Renderer::Evaluate(const SplatModel& model, const Scene& scene) {
  return Evaluate(ToKernelModel(model), scene);
}

Evaluation Renderer::Evaluate(const splat::Model<float>& model, const Scene& scene, const MeasuredViews& measured) {
  return gs::Evaluate<CpuBackend<float>>(scene, background_, {}, model, workspace_, measured);
}

}  // namespace vesta::gs
