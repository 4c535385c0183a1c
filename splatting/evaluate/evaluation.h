// SPDX-License-Identifier: Apache-2.0
// Image quality of a model over the views of a scene, in any memory space.
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

// Means over views, from unmasked pixels of images quantised to 8 bits.
struct Quality {
  double psnr = 0;  // dB
  double ssim = 0;
  int views = 0;
};

struct Evaluation {
  Quality train, held_out, test;  // 0 without views; test: NaN without views
  double cost = 0;                // mean over measured training views, pixels and channels of 0.8 |e| + 0.2 (1 - SSIM)
};

// The measurements of one view.
struct ViewQuality {
  std::size_t view;      // index in the scene
  ImageQuality quality;  // over unmasked pixels
  double counted;        // fraction of unmasked pixels
  double objective;      // photometric loss of the unquantised image; 0 unless a training view
};
// whole: quality over all pixels, with masked pixels replaced by the photograph (masked_loss.h).
ViewQuality QualityOf(std::size_t view, const Image& photograph, const ImageQuality& whole, double objective);
// Means over the measured views, given in any order.
Evaluation MeanOf(const std::vector<View>& views, std::vector<ViewQuality> measured);

// The views that are measured, and the processes that share the work.
struct MeasuredViews {
  // Maximum number of training views, evenly spaced. All other views are measured.
  int most_trained = std::numeric_limits<int>::max();
  ProcessGroup processes = {};  // each measures its share of the views
};

// For each view of a scene, whether any process measures it.
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

// Evaluates a model in the memory of B. held: the training views in the order of the scene, if B already has their
// photographs; may be empty. Other photographs are copied to B one at a time. All processes return the same result. Its
// view and two images are freed on return. On a device, throws OutOfDeviceMemory.
template <class B>
Evaluation Evaluate(const Scene& scene, const std::array<double, 3>& background, std::span<const TargetView<B>> held,
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
    if (!view.is_trained() || held.empty()) {
      Splats::CopyTruth(ValuesOf(*photograph), truth);
    } else {
      VESTA_CHECK(place < held.size(), "the {} targets are fewer than the training views", held.size());
      Splats::CopyTruth(typename B::ConstVectorView(held[place].truth), truth);
    }
    ShowLeftOut<B>(Splats::MakeMask(MaskOf(*photograph)), typename B::ConstVectorView(truth), rendered.view());
    // Before the meter, which may modify both images.
    const double objective = view.is_trained() ? loss.Evaluate(rendered, truth, shape).objective : 0;
    qualities.push_back(QualityOf(v, *photograph, meter.Measure(rendered, truth, shape), objective));
  }
  return MeanOf(scene.views, measured.processes.Gather(qualities));
}

// Prepares a rendered image for comparison: copies masked pixels from the photograph.
Image ToCompare(Image rendered, const Image& photograph);

// Renders views of models. Keeps its working memory between calls.
class Renderer {
 public:
  // background: 0..1. near: distance of the near plane, world units.
  Renderer(const std::array<double, 3>& background, double near) : background_(background), near_(near) {}

  // The model seen from the view; colours are not clamped.
  Image Render(const SplatModel& model, const View& view);
  Evaluation Evaluate(const SplatModel& model, const Scene& scene);
  // The same for a model in training, which may have fewer active SH bands.
  Evaluation Evaluate(const splat::Model<float>& model, const Scene& scene, const MeasuredViews& measured = {});

 private:
  std::array<double, 3> background_;
  double near_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

}  // namespace vesta::gs
