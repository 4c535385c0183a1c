#include "problems/gaussian_splatting/parsimony/worth.h"

#include <array>
#include <cmath>
#include <limits>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/splat_view.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::gs {
namespace {

// Renders the model into one judge after the other.
class RenderedViews {
 public:
  RenderedViews(const splat::Model<float>& model, const JudgingViews& judges) : model_(model), judges_(judges) {}

  // body(view): with view() and image() of that judge.
  template <class Body>
  void ForEach(const Body& body) {
    for (const View* view : judges_.views) {
      image_.ResizeForOverwrite(ImageShape{view->camera.width, view->camera.height}.NumValues());
      view_.Build(model_, ToPosedCamera(*view, judges_.near), judges_.background.data(), workspace_);
      view_.Render(image_.data());
      body(*view);
    }
  }
  const splat::SplatView<float>& view() const { return view_; }
  const HostBuffer<float>& image() const { return image_; }
  splat::ViewWorkspace<float>& workspace() { return workspace_; }

 private:
  const splat::Model<float>& model_;
  const JudgingViews& judges_;
  splat::SplatView<float> view_;
  splat::ViewWorkspace<float> workspace_;
  HostBuffer<float> image_;
};

// Of a symmetric matrix of order 6 by its lower triangle, which is overwritten; -infinity where it is not definite.
double LogDeterminant(std::array<double, 21>& a) {
  double log_det = 0;
  for (int k = 0; k < 6; ++k) {
    const double pivot = a[static_cast<std::size_t>(PackedLower(k, k))];
    if (!(pivot > 0)) return -std::numeric_limits<double>::infinity();
    log_det += std::log(pivot);
    for (int i = k + 1; i < 6; ++i) {
      const double factor = a[static_cast<std::size_t>(PackedLower(i, k))] / pivot;
      for (int j = k + 1; j <= i; ++j) {
        a[static_cast<std::size_t>(PackedLower(i, j))] -= factor * a[static_cast<std::size_t>(PackedLower(j, k))];
      }
    }
  }
  return log_det;
}

}  // namespace

Worth MeasureWorth(const splat::Model<float>& model, const JudgingViews& judges) {
  const auto n = static_cast<std::size_t>(model.count);
  std::vector<splat::Removal<double>> removals(n);
  Worth worth;
  PhotometricLoss<float> loss;
  const PhotometricWeights& weights = loss.weights();
  PhotometricLinearization<float> linearization;
  HostBuffer<float> gradient;
  RenderedViews rendered(model, judges);
  rendered.ForEach([&](const View& view) {
    const ImageShape shape{view.camera.width, view.camera.height};
    gradient.ResizeForOverwrite(shape.NumValues());
    const HostSpan<const float> truth{view.image.rgb.data(), shape.NumValues()};
    worth.cost += loss.Linearize(rendered.image(), truth, shape, gradient, linearization).objective;
    rendered.view().AddRemovals({.rendered = rendered.image().data(),
                                 .truth = truth.data(),
                                 .gradient = gradient.data(),
                                 .diagonal = linearization.diagonal.data(),
                                 .curvature = linearization.curvature.data(),
                                 .penalty = PenaltyCoefficientsOf<float>(weights),
                                 .l1 = static_cast<float>(weights.l1),
                                 .ssim = static_cast<float>(weights.ssim),
                                 .window_variance = static_cast<float>(WindowVariance())},
                                removals.data(), rendered.workspace());
  });
  worth.rise.resize(n), worth.weight.resize(n);
  for (std::size_t i = 0; i < n; ++i) worth.rise[i] = removals[i].rise, worth.weight[i] = removals[i].weight;
  return worth;
}

std::vector<double> MeasureSensitivity(const splat::Model<float>& model, const JudgingViews& judges) {
  const Index n = model.count;
  constexpr Index kEntries = splat::kGeometry * (splat::kGeometry + 1) / 2;
  std::vector<float> blocks(static_cast<std::size_t>(kEntries * n));
  std::vector<float> sh_diagonal(static_cast<std::size_t>(model.Size() - model.Offset(splat::kSh)));
  std::vector<float> ones;
  RenderedViews rendered(model, judges);
  rendered.ForEach([&](const View&) {
    ones.assign(static_cast<std::size_t>(rendered.image().size()), 1.0f);
    rendered.view().AddGram(model, rendered.image().data(), ones.data(), blocks.data(), sh_diagonal.data(),
                            rendered.workspace());
  });
  std::vector<double> sensitivity(static_cast<std::size_t>(n));
  constexpr int kOrder = 6;
  static_assert(splat::kMean == 0 && splat::kLogScale == 3 && splat::kQuaternion == kOrder);
  ParallelFor(n, 1024, [&](Index i) {
    std::array<double, kOrder*(kOrder + 1) / 2> block{};
    for (std::size_t e = 0; e < block.size(); ++e) {
      block[e] = static_cast<double>(blocks[e * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)]);
    }
    double log_det = LogDeterminant(block);
    // By the standard deviations themselves, not their logarithms.
    for (int k = splat::kLogScale; k < splat::kQuaternion; ++k) {
      log_det -= 2 * static_cast<double>(model.x[k * n + i]);
    }
    sensitivity[static_cast<std::size_t>(i)] = log_det;
  });
  return sensitivity;
}

}  // namespace vesta::gs
