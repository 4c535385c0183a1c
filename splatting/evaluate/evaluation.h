// SPDX-License-Identifier: Apache-2.0
// Image quality of a model over the views of a scene. B: backend (kernels/core/vector_backend.h) for host or GPU
// memory.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/image/metrics.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/distributed/process_group.h"

namespace vesta::gs {

// Means over views, from unmasked pixels quantised to 8 bits.
struct Quality {
  double psnr = 0;  // dB
  double ssim = 0;
  int views = 0;
};

struct Evaluation {
  Quality train, held_out, test;  // without views, train and test are NaN, and held_out is 0
  // Mean over measured training views, pixels and channels of 0.8 |e| + 0.2 (1 - SSIM); NaN without such views.
  double cost = 0;
};

struct ViewQuality {
  std::size_t view;      // index in the scene
  ImageQuality quality;  // over unmasked pixels
  double counted;        // fraction of unmasked pixels
  double objective;      // training view: unquantised loss, summed over pixels and channels; else 0
};
// whole: quality over all pixels of an image whose masked pixels come from the photograph (masked_loss.h). The result
// is the quality over unmasked pixels.
ViewQuality QualityOf(std::size_t view, const Image& photograph, const ImageQuality& whole, double objective);
// measured: in any order. views: all views of the scene.
Evaluation MeanOf(const std::vector<View>& views, std::vector<ViewQuality> measured);

// The measured views, and the processes that share the work.
struct MeasuredViews {
  // At most this many training views, evenly spaced. All held-out and test views are measured.
  int most_trained = std::numeric_limits<int>::max();
  ProcessGroup processes = {};  // each measures its share of the views
};

// True for each view that any process measures.
inline std::vector<bool> AreMeasured(const MeasuredViews& measured, const std::vector<View>& views) {
  const Index trained = NumTrainingViews(views);
  const Index most = std::min<Index>(measured.most_trained, trained);
  std::vector<bool> are_measured;
  are_measured.reserve(views.size());
  Index place = 0;  // index among the training views
  for (const View& view : views) {
    // The last view of every run of trained / most training views.
    are_measured.push_back(!view.is_trained() || (place + 1) * most / trained > place * most / trained);
    if (view.is_trained()) ++place;
  }
  return are_measured;
}

// Evaluates a model in the memory of B. targets: all training views, in the order of the scene, if their photographs
// are in that memory; else empty. Other photographs are copied there one at a time. Collective; all processes return
// the same result. On a device, throws OutOfDeviceMemory if memory runs out.
template <class B>
Evaluation Evaluate(const Scene& scene, const std::array<double, 3>& background, std::span<const TargetView<B>> targets,
                    const splat::Model<float>& model, typename SplatBackend<B>::Workspace& workspace,
                    const MeasuredViews& measured = {}) {
  using Splats = SplatBackend<B>;
  const Share own = measured.processes.OwnShare(std::ssize(scene.views));
  const std::vector<bool> is_measured = AreMeasured(measured, scene.views);
  std::vector<ViewQuality> qualities;
  typename Splats::QualityMeter meter;
  typename Splats::Loss loss;
  typename Splats::SplatView splats;
  typename B::Vector rendered;
  typename Splats::Truth truth;
  std::size_t trained = 0;  // training views so far
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const std::size_t place = trained;
    if (view.is_trained()) ++trained;
    if (std::cmp_less(v, own.begin) || std::cmp_greater_equal(v, own.end) || !is_measured[v]) continue;
    const ImageShape shape{view.camera.width, view.camera.height};
    const std::shared_ptr<const Image> photograph = view.Photograph();
    rendered.ResizeForOverwrite(shape.NumValues());
    splats.Build(model, ToPosedCamera(view, NearPlane(scene)), background.data(), workspace);
    splats.Render(rendered.data());
    if (!view.is_trained() || targets.empty()) {
      Splats::CopyTruth(ValuesOf(*photograph), truth);
    } else {
      VESTA_CHECK(place < targets.size(), "the {} targets are fewer than the training views", targets.size());
      Splats::CopyTruth(typename B::ConstVectorView(targets[place].truth), truth);
    }
    FillMasked<B>(Splats::MakeMask(MaskOf(*photograph)), typename B::ConstVectorView(truth), rendered.view());
    // The loss first: the meter may modify both images.
    const double objective = view.is_trained() ? loss.Evaluate(rendered, truth, shape).objective : 0;
    qualities.push_back(QualityOf(v, *photograph, meter.Measure(rendered, truth, shape), objective));
  }
  return MeanOf(scene.views, measured.processes.Gather(qualities));
}

// Copies the masked pixels of the photograph, so that they do not count as errors.
Image ToCompare(Image rendered, const Image& photograph);

// Renders views of models. Keeps its work memory between calls.
class Renderer {
 public:
  // background: 0..1. near: distance of the near plane, world units.
  Renderer(const std::array<double, 3>& background, double near) : background_(background), near_(near) {}

  // Colours are not clamped.
  Image Render(const SplatModel& model, const View& view);
  Evaluation Evaluate(const SplatModel& model, const Scene& scene);
  // The model may be in training, with fewer active SH bands.
  Evaluation Evaluate(const splat::Model<float>& model, const Scene& scene, const MeasuredViews& measured = {});

 private:
  std::array<double, 3> background_;
  double near_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

}  // namespace vesta::gs
