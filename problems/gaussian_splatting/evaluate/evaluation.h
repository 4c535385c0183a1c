// Image quality of a model over the views of a scene, in any memory space.
#pragma once

#include <array>
#include <span>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/evaluate/metrics.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

// Of a model in the memory of B. held: the training views, in the order of the scene, where their truths are there
// already; those of the other views are shown to B one at a time. Holds its view and two images only while it runs; on
// a device throws OutOfDeviceMemory.
template <class B>
Evaluation Evaluate(const Scene& scene, const std::array<double, 3>& background, std::span<const TargetView<B>> held,
                    const splat::Model<float>& model, typename SplatBackend<B>::Workspace& workspace) {
  using Splats = SplatBackend<B>;
  EvaluationSum sum;
  typename Splats::QualityMeter meter;
  typename Splats::Loss loss;
  typename Splats::SplatView splats;
  typename B::Vector rendered;
  typename Splats::Truth truth;
  std::size_t next = 0;
  for (const View& view : scene.views) {
    const ImageShape shape{view.camera.width, view.camera.height};
    const std::shared_ptr<const Image> photograph = view.Photograph();
    rendered.ResizeForOverwrite(shape.NumValues());
    splats.Build(model, ToPosedCamera(view, NearPlane(scene)), background.data(), workspace);
    splats.Render(rendered.data());
    if (!view.is_trained() || held.empty()) {
      Splats::Show(ValuesOf(*photograph), truth);
    } else {
      VESTA_CHECK(next < held.size(), "{} targets are fewer than the training views", held.size());
      Splats::Show(typename B::ConstView(held[next++].truth), truth);
    }
    ShowLeftOut<B>(Splats::MakeMask(MaskOf(*photograph)), typename B::ConstView(truth), rendered.view());
    // Before the meter, which may write into both images.
    const double objective = view.is_trained() ? loss.Evaluate(rendered, truth, shape).objective : 0;
    sum.Add(view, *photograph, meter.Measure(rendered, truth, shape), objective);
  }
  return sum.Mean();
}

}  // namespace vesta::gs
