// SPDX-License-Identifier: Apache-2.0
// The views by which Gaussians are judged, and the rise of their cost without each Gaussian.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/distributed/process_group.h"

namespace vesta::gs {

// The views that speak for or against a Gaussian: those that are trained on, with their images, never the test views.
struct ScoringViews {
  std::vector<const View*> views;  // must outlive this
  std::array<double, 3> background{0, 0, 0};
  double near = 0;              // distance of the near plane, world units
  ProcessGroup processes = {};  // each asks its share of the views
};

// The training views of the scene.
ScoringViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background,
                             const ProcessGroup& processes = {});

// Bytes of a RenderedViews and a JudgedLoss of such a model and its largest view, with what they sum up by pair and
// splat; the passes over single Gaussians besides.
inline double RenderedViewsBytes(const splat::ViewCounts& view, double gaussians) {
  using Workspace = splat::ViewWorkspace<float>;
  constexpr double kSums = sizeof(splat::RecolorRises<float>),
                   kImages = 2 + LinearizationImages(SsimLinearization::kQuadratic);
  return splat::SplatView<float>::Bytes(view, gaussians) + Workspace::BuildBytes(view, gaussians) +
         splat::kSpareRoom * (view.splats + view.pairs) * kSums + view.splats * sizeof(splat::Recolors<float>) +
         kImages * kImageBytes * view.pixels +
         PhotometricLoss<float>::GradientBytes(SsimLinearization::kQuadratic, view.pixels);
}

// Renders the model into one judge after the other.
class RenderedViews {
 public:
  // Both must outlive this.
  RenderedViews(const splat::Model<float>& model, const ScoringViews& judges) : model_(model), judges_(judges) {}

  // What judges tell of the Gaussians that they see. ask(view, rows), with view() and image() of that judge: adds to
  // rows, one for each Gaussian and zero before. take(view) gives what takes (i, row) of each that is seen, the judges
  // in their order, Gaussians in parallel. Of several processes each asks its own judges, and all take what all were
  // told. Row: some numbers, zeros by default.
  template <class Row, class Ask, class Take>
  void ForEachAnswer(const Ask& ask, const Take& take);
  const splat::SplatView<float>& view() const { return view_; }
  const HostBuffer<float>& image() const { return image_; }
  splat::ViewWorkspace<float>& workspace() { return workspace_; }

 private:
  static constexpr Index kGrain = 1024;
  void Render(const View& view) {
    image_.ResizeForOverwrite(ImageShape{view.camera.width, view.camera.height}.NumValues());
    view_.Build(model_, ToPosedCamera(view, judges_.near), judges_.background.data(), workspace_);
    view_.Render(image_.data());
  }

  const splat::Model<float>& model_;
  const ScoringViews& judges_;
  splat::SplatView<float> view_;
  splat::ViewWorkspace<float> workspace_;
  HostBuffer<float> image_;
};

template <class Row, class Ask, class Take>
void RenderedViews::ForEachAnswer(const Ask& ask, const Take& take) {
  struct Answer {
    std::int32_t gaussian;
    Row row;
  };
  static_assert(std::is_trivially_copyable_v<Row>);
  const auto views = static_cast<Index>(judges_.views.size());
  const Share own = judges_.processes.OwnShare(views);
  const bool is_alone = judges_.processes.is_alone();
  std::vector<Row> rows;
  std::vector<std::vector<Answer>> told(static_cast<std::size_t>(is_alone ? 0 : own.size()));
  for (Index v = own.begin; v < own.end; ++v) {
    const View& view = *judges_.views[static_cast<std::size_t>(v)];
    Render(view);
    rows.assign(static_cast<std::size_t>(model_.count), Row());
    ask(view, rows.data());
    if (is_alone) {
      const auto take_row = take(view);
      ParallelFor(model_.count, kGrain, [&](Index i) {
        if (view_.rank_of()[i] >= 0) take_row(i, rows[static_cast<std::size_t>(i)]);
      });
      continue;
    }
    std::vector<Answer>& answers = told[static_cast<std::size_t>(v - own.begin)];
    answers.reserve(static_cast<std::size_t>(view_.num_splats()));
    for (Index i = 0; i < model_.count; ++i) {
      if (view_.rank_of()[i] >= 0) answers.push_back({static_cast<std::int32_t>(i), rows[static_cast<std::size_t>(i)]});
    }
  }
  if (is_alone) return;
  for (Index v = 0; v < views; ++v) {
    const bool is_own = v >= own.begin && v < own.end;
    const std::vector<Answer> answers = judges_.processes.Gather(
        is_own ? std::exchange(told[static_cast<std::size_t>(v - own.begin)], {}) : std::vector<Answer>());
    const auto take_row = take(*judges_.views[static_cast<std::size_t>(v)]);
    ParallelFor(static_cast<Index>(answers.size()), kGrain, [&](Index k) {
      const Answer& answer = answers[static_cast<std::size_t>(k)];
      take_row(Index{answer.gaussian}, answer.row);
    });
  }
}

// The loss that trainings lower, 0.8 |e| + 0.2 (1 - SSIM) summed over pixels and channels, for passes that ask what
// changes of it.
class JudgedLoss {
 public:
  // Of that view, until the next call; counted in what follows.
  splat::LinearizedLoss<float> Linearize(HostSpan<const float> rendered, const View& view) {
    const ImageShape shape{view.camera.width, view.camera.height};
    photograph_.reset();  // before the next one takes its room
    photograph_ = view.Photograph();
    const HostSpan<const float> truth = ValuesOf(*photograph_);
    const PhotometricWeights& weights = loss_.weights();
    gradient_.ResizeForOverwrite(shape.NumValues());
    const bool is_masked = !photograph_->mask.empty();
    if (is_masked) rendered = WithPhotograph(rendered, *photograph_);
    costs_.push_back(loss_.Linearize(rendered, truth, shape, gradient_, linearization_).objective);
    values_.push_back(ImageShape::kChannels * static_cast<double>(CountedPixels(*photograph_)));
    return {.rendered = rendered.data(),
            .truth = truth.data(),
            .gradient = gradient_.data(),
            .diagonal = linearization_.diagonal.data(),
            .curvature = linearization_.curvature.data(),
            .penalty = PenaltyCoefficientsOf<float>(weights),
            .l1 = static_cast<float>(weights.l1),
            .ssim = static_cast<float>(weights.ssim),
            .window_variance = static_cast<float>(WindowVariance()),
            .counts = is_masked ? counts_.data() : nullptr};
  }
  // Of all views, those of other processes among them; their pixels that count, by channel. Collective.
  double Cost(const ScoringViews& judges) const { return SumInOrder(judges.processes.Gather(costs_)); }
  double Values(const ScoringViews& judges) const { return SumInOrder(judges.processes.Gather(values_)); }

 private:
  static double SumInOrder(const std::vector<double>& of_views) {
    return std::accumulate(of_views.begin(), of_views.end(), 0.0);
  }
  // The image with the photograph where pixels do not count; and counts_.
  HostSpan<const float> WithPhotograph(HostSpan<const float> rendered, const Image& photograph) {
    using Backend = CpuBackend<float>;
    shown_.CopyFrom(rendered);
    ShowLeftOut<Backend>(MaskOf(photograph), ValuesOf(photograph), shown_.view());
    counts_.assign(photograph.mask.begin(), photograph.mask.end());
    for (float& count : counts_) count = count != 0 ? 1.0f : 0.0f;
    return shown_.view();
  }

  std::shared_ptr<const Image> photograph_;
  PhotometricLoss<float> loss_;
  PhotometricLinearization<float> linearization_;
  HostBuffer<float> gradient_, shown_;
  std::vector<float> counts_;
  std::vector<double> costs_, values_;  // by view
};

// What each Gaussian of a model is worth: by how much the photometric cost of the training views rises without it
// (kernels/gaussian_splatting/raster/removal_pass.h).
// Costs are sums over views, pixels and channels of the loss that trainings lower: 0.8 |e| + 0.2 (1 - SSIM).
struct RemovalCost {
  double cost = 0;           // of the views with all Gaussians
  double values = 0;         // pixels of the views, by channel
  std::vector<double> rise;  // by Gaussian: when it goes and all others stay as they are; negative: better without
};

// Takes about three times as long as rendering all views.
RemovalCost MeasureRemovalCost(const splat::Model<float>& model, const ScoringViews& judges);

}  // namespace vesta::gs
