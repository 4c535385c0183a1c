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

// Means over views of values per view, of the pixels that count, on 8-bit-quantised images.
struct Quality {
  double psnr = 0;  // dB
  double ssim = 0;
  int views = 0;
};

struct Evaluation {
  Quality train, held_out, test;  // of no views 0; of no test views NaN
  double cost = 0;                // mean over measured training views, pixels and channels of 0.8 |e| + 0.2 (1 - SSIM)
};

// What is measured of one view.
struct ViewQuality {
  std::size_t view;      // of the scene's
  ImageQuality quality;  // of the pixels that count
  double counted;        // their part of all
  double objective;  // of the photometric loss on the image as rendered; only of views that are trained on it counts
};
// whole: of the view with its photograph where pixels do not count (masked_loss.h).
ViewQuality QualityOf(std::size_t view, const Image& photograph, const ImageQuality& whole, double objective);
// Of all views, in any order.
Evaluation MeanOf(const std::vector<View>& views, std::vector<ViewQuality> measured);

// Of which views a model is measured, by which process.
struct MeasuredViews {
  // Of the training views as many at most, evenly spread; of the others all.
  int most_trained = std::numeric_limits<int>::max();
  ProcessGroup processes = {};  // each measures its share of the views
};

// Of each view of a scene whether it is one of them, of any process.
inline std::vector<bool> AreMeasured(const MeasuredViews& measured, const std::vector<View>& views) {
  const Index trained = NumTrainingViews(views);
  const Index most = std::min<Index>(measured.most_trained, trained);
  std::vector<bool> are_measured;
  are_measured.reserve(views.size());
  Index place = 0;  // among the training views
  for (const View& view : views) {
    // Of every run of trained / most views the last.
    are_measured.push_back(!view.is_trained() || (place + 1) * most / trained > place * most / trained);
    if (view.is_trained()) ++place;
  }
  return are_measured;
}

// Of a model in the memory of B. held: the training views, in the order of the scene, where their truths are there
// already; those of the other views are shown to B one at a time. Processes that measure together all have the same
// result. Holds its view and two images only while it runs; on a device throws OutOfDeviceMemory.
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
  std::size_t trained = 0;  // views so far
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
      VESTA_CHECK(place < held.size(), "{} targets are fewer than the training views", held.size());
      Splats::CopyTruth(typename B::ConstVectorView(held[place].truth), truth);
    }
    ShowLeftOut<B>(Splats::MakeMask(MaskOf(*photograph)), typename B::ConstVectorView(truth), rendered.view());
    // Before the meter, which may write into both images.
    const double objective = view.is_trained() ? loss.Evaluate(rendered, truth, shape).objective : 0;
    qualities.push_back(QualityOf(v, *photograph, meter.Measure(rendered, truth, shape), objective));
  }
  return MeanOf(scene.views, measured.processes.Gather(qualities));
}

// A rendered image as it is compared with its photograph: pixels that do not count show what that shows.
Image ToCompare(Image rendered, const Image& photograph);

// Renders views of models; keeps its working memory between calls.
class Renderer {
 public:
  // background: 0..1. near: distance of the near plane, world units.
  Renderer(const std::array<double, 3>& background, double near) : background_(background), near_(near) {}

  // The model seen from the view, not clamped.
  Image Render(const SplatModel& model, const View& view);
  Evaluation Evaluate(const SplatModel& model, const Scene& scene);
  // The same for a model still in training, with fewer active SH bands.
  Evaluation Evaluate(const splat::Model<float>& model, const Scene& scene, const MeasuredViews& measured = {});

 private:
  std::array<double, 3> background_;
  double near_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

}  // namespace vesta::gs
