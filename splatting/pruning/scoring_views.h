// SPDX-License-Identifier: Apache-2.0
// Scores for pruning from the scoring views, which are training views. The score of a Gaussian is its removal cost: the
// predicted rise of the views' loss if the Gaussian is removed.
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

// Test and held-out views never score Gaussians.
struct ScoringViews {
  std::vector<const View*> views;  // must outlive this object
  std::array<double, 3> background{0, 0, 0};
  double near = 0;              // distance of the near plane, world units
  ProcessGroup processes = {};  // each process renders its share of the views
};

ScoringViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background,
                             const ProcessGroup& processes = {});

// Bytes of a RenderedViews and a ScoringLoss together, including the workspace of the scoring passes, but not arrays
// with one element per Gaussian, such as the rows of ForEachGathered. view: the maximum of each count over the views.
inline double RenderedViewsBytes(const splat::ViewCounts& view, double gaussians) {
  using Workspace = splat::ViewWorkspace<float>;
  constexpr double kSums = sizeof(splat::RecolorRises<float>),
                   kImages = 2 + LinearizationImages(SsimLinearization::kQuadratic);
  return splat::SplatView<float>::Bytes(view, gaussians) + Workspace::BuildBytes(view, gaussians) +
         splat::kSpareCapacity * (view.splats + view.pairs) * kSums + view.splats * sizeof(splat::Recolors<float>) +
         kImages * kImageBytes * view.pixels +
         PhotometricLoss<float>::GradientBytes(SsimLinearization::kQuadratic, view.pixels);
}

// Renders the model into the scoring views in turn.
class RenderedViews {
 public:
  // Both must outlive this object.
  RenderedViews(const splat::Model<float>& model, const ScoringViews& scoring_views)
      : model_(model), scoring_views_(scoring_views) {}

  // Computes a value of type Row for each Gaussian and each view that sees it.
  //
  // compute(view, rows) is called once per rendered view; view(), image() and workspace() then belong to this view.
  // `compute` adds to the rows, one per Gaussian, which start at zero. apply(view) is called once per view, in order.
  // It returns a function f; f(i, row) is then called for each visible Gaussian i, in parallel.
  //
  // Collective. Each process calls `compute` for its share of the views, and `apply` for all views, with the rows of
  // all processes.
  template <class Row, class Compute, class Apply>
  void ForEachGathered(const Compute& compute, const Apply& apply);
  const splat::SplatView<float>& view() const { return view_; }
  const HostBuffer<float>& image() const { return image_; }
  splat::ViewWorkspace<float>& workspace() { return workspace_; }

 private:
  static constexpr Index kGrain = 1024;
  void Render(const View& view) {
    image_.ResizeForOverwrite(ImageShape{view.camera.width, view.camera.height}.NumValues());
    view_.Build(model_, ToPosedCamera(view, scoring_views_.near), scoring_views_.background.data(), workspace_);
    view_.Render(image_.data());
  }

  const splat::Model<float>& model_;
  const ScoringViews& scoring_views_;
  splat::SplatView<float> view_;
  splat::ViewWorkspace<float> workspace_;
  HostBuffer<float> image_;
};

template <class Row, class Compute, class Apply>
void RenderedViews::ForEachGathered(const Compute& compute, const Apply& apply) {
  struct GaussianRow {
    std::int32_t gaussian;
    Row row;
  };
  static_assert(std::is_trivially_copyable_v<Row>);
  const auto views = static_cast<Index>(scoring_views_.views.size());
  const Share own = scoring_views_.processes.OwnShare(views);
  const bool is_alone = scoring_views_.processes.is_alone();
  std::vector<Row> rows;
  std::vector<std::vector<GaussianRow>> own_rows(static_cast<std::size_t>(is_alone ? 0 : own.size()));
  for (Index v = own.begin; v < own.end; ++v) {
    const View& view = *scoring_views_.views[static_cast<std::size_t>(v)];
    Render(view);
    rows.assign(static_cast<std::size_t>(model_.count), Row());
    compute(view, rows.data());
    if (is_alone) {
      const auto apply_row = apply(view);
      ParallelFor(model_.count, kGrain, [&](Index i) {
        if (view_.rank_of()[i] >= 0) apply_row(i, rows[static_cast<std::size_t>(i)]);
      });
      continue;
    }
    std::vector<GaussianRow>& view_rows = own_rows[static_cast<std::size_t>(v - own.begin)];
    view_rows.reserve(static_cast<std::size_t>(view_.num_splats()));
    for (Index i = 0; i < model_.count; ++i) {
      if (view_.rank_of()[i] >= 0) {
        view_rows.push_back({static_cast<std::int32_t>(i), rows[static_cast<std::size_t>(i)]});
      }
    }
  }
  if (is_alone) return;
  for (Index v = 0; v < views; ++v) {
    const bool is_own = v >= own.begin && v < own.end;
    const std::vector<GaussianRow> view_rows = scoring_views_.processes.Gather(
        is_own ? std::exchange(own_rows[static_cast<std::size_t>(v - own.begin)], {}) : std::vector<GaussianRow>());
    const auto apply_row = apply(*scoring_views_.views[static_cast<std::size_t>(v)]);
    ParallelFor(static_cast<Index>(view_rows.size()), kGrain, [&](Index k) {
      const GaussianRow& entry = view_rows[static_cast<std::size_t>(k)];
      apply_row(Index{entry.gaussian}, entry.row);
    });
  }
}

// The training loss, 0.8 |e| + 0.2 (1 - SSIM) summed over pixels and channels, as a quadratic approximation that
// predicts how the loss changes.
class ScoringLoss {
 public:
  // Computes the quadratic for this view, and adds the view to Cost and Values. rendered: its rendered image. The
  // result is valid until the next call.
  splat::LinearizedLoss<float> Linearize(HostSpan<const float> rendered, const View& view) {
    const ImageShape shape{view.camera.width, view.camera.height};
    photograph_.reset();  // frees its memory before the next one is loaded
    photograph_ = view.Photograph();
    const HostSpan<const float> truth = ValuesOf(*photograph_);
    const PhotometricWeights& weights = loss_.weights();
    gradient_.ResizeForOverwrite(shape.NumValues());
    const bool is_masked = !photograph_->mask.empty();
    if (is_masked) rendered = WithPhotograph(rendered, *photograph_);
    costs_.push_back(loss_.Linearize(rendered, truth, shape, gradient_, linearization_).objective);
    values_.push_back(ImageShape::kChannels * static_cast<double>(UnmaskedPixels(*photograph_)));
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
  // Loss of all views of all processes, and its number of values: unmasked pixels times channels. Collective.
  double Cost(const ScoringViews& scoring_views) const { return SumInOrder(scoring_views.processes.Gather(costs_)); }
  double Values(const ScoringViews& scoring_views) const { return SumInOrder(scoring_views.processes.Gather(values_)); }

 private:
  static double SumInOrder(const std::vector<double>& of_views) {
    return std::accumulate(of_views.begin(), of_views.end(), 0.0);
  }
  // Replaces masked pixels by the photograph. Sets counts_.
  HostSpan<const float> WithPhotograph(HostSpan<const float> rendered, const Image& photograph) {
    using Backend = CpuBackend<float>;
    shown_.CopyFrom(rendered);
    FillMasked<Backend>(MaskOf(photograph), ValuesOf(photograph), shown_.view());
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

// Removal cost of each Gaussian, predicted by kernels/gaussian_splatting/raster/loss_passes.h. The loss is 0.8 |e| +
// 0.2 (1 - SSIM), summed over views, pixels and channels.
struct RemovalCost {
  double loss = 0;                   // with all Gaussians
  double values = 0;                 // unmasked pixels of the views times channels
  std::vector<double> rise;          // loss without this Gaussian minus loss with it, all others fixed
  std::vector<double> largest_rise;  // the largest rise of one view; at least 0
};

// Takes the time of about three renderings of all views. Collective.
RemovalCost MeasureRemovalCost(const splat::Model<float>& model, const ScoringViews& scoring_views);

}  // namespace vesta::gs
