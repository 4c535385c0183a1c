#include "problems/gaussian_splatting/parsimony/worth.h"

#include <array>
#include <cmath>
#include <limits>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/parsimony/rendered_views.h"

namespace vesta::gs {
namespace {

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
  RenderedViews rendered(model, judges);
  JudgedLoss judged;
  rendered.ForEachAnswer<splat::Removal<double>>(
      [&](const View& view, splat::Removal<double>* rows) {
        rendered.view().AddRemovals(judged.Linearize(rendered.image(), view), rows, rendered.workspace());
      },
      [&](const View&) {
        return [&](Index i, const splat::Removal<double>& row) {
          splat::Removal<double>& sum = removals[static_cast<std::size_t>(i)];
          sum.rise += row.rise, sum.weight += row.weight;
        };
      });
  Worth worth{.cost = judged.Cost(judges), .values = judged.Values(judges), .rise = {}, .weight = {}};
  worth.rise.resize(n), worth.weight.resize(n);
  for (std::size_t i = 0; i < n; ++i) worth.rise[i] = removals[i].rise, worth.weight[i] = removals[i].weight;
  return worth;
}

std::vector<double> MeasureSensitivity(const splat::Model<float>& model, const JudgingViews& judges) {
  const Index n = model.count;
  constexpr Index kEntries = PackedSize(splat::kGeometry);
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
    std::array<double, PackedSize(kOrder)> block{};
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
