// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/harmonics.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/block_lanes.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/formulas/color.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {
namespace {

constexpr int kBases = kMaxShCoefficients, kBlock = PackedSize(kBases);
constexpr Index kGrain = 256;

// Active degree.
int DegreeOf(const splat::Model<float>& model, Index i) { return std::min(model.DegreeOf(i), model.active_sh_degree); }

std::array<float, 3> CentreOf(const splat::PosedCamera& camera) {
  return {static_cast<float>(camera.centre[0]), static_cast<float>(camera.centre[1]),
          static_cast<float>(camera.centre[2])};
}

// SH basis functions in the viewing direction of a Gaussian from this camera centre.
std::array<float, kBases> BasisSeen(const splat::Model<float>& model, Index i, const std::array<float, 3>& centre) {
  float mean[3], dir[3];
  for (int k = 0; k < 3; ++k) mean[k] = model.x[model.Offset(splat::kMean + k) + i];
  splat::ViewDirection(centre.data(), mean, dir);
  std::array<float, kBases> basis{};
  ShBasis<3>(dir[0], dir[1], dir[2], basis.data());
  return basis;
}

// Second derivative of the loss with respect to the SH coefficients of a Gaussian: packed, mean over the channels.
using Curvature = std::array<float, kBlock>;

// Sum over the views.
std::vector<Curvature> Curvatures(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  std::vector<Curvature> sums(static_cast<std::size_t>(model.count), Curvature{});
  RenderedViews rendered(model, scoring_views);
  ScoringLoss loss;
  rendered.ForEachGathered<float>(
      [&](const View& view, float* bends) {
        const splat::ColorCurvature<float>* colors =
            rendered.view().ColorCurvatures(loss.Linearize(rendered.image(), view), rendered.workspace());
        ParallelFor(model.count, kGrain, [&](Index i) {
          const std::int32_t rank = rendered.view().rank_of()[i];
          if (rank < 0) return;
          const splat::Splat<float>& splat = rendered.view().splats()[rank];
          for (int c = 0; c < 3; ++c) bends[i] += splat.color[c] > 0 ? colors[rank].channel[c] / 3 : 0;  // 0: clamped
        });
      },
      [&](const View& view) {
        return [&, centre = CentreOf(ToPosedCamera(view, scoring_views.near))](Index i, float bend) {
          const std::array<float, kBases> basis = BasisSeen(model, i, centre);
          Curvature& sum = sums[static_cast<std::size_t>(i)];
          const int bases = ShCoefficients(DegreeOf(model, i));
          for (int row = 0; row < bases; ++row) {
            for (int col = 0; col <= row; ++col) sum[PackedLower(row, col)] += bend * basis[row] * basis[col];
          }
        };
      });
  return sums;
}

// Coefficients of the first `kept` basis functions, channel c at [3 k + c], that best replace all `bases`. A little
// damping preserves coefficients that the views do not determine.
void StandIn(const Curvature& curvature, const float* coefficients, int bases, int kept, float* stand_in) {
  constexpr float kDamping = 1e-3f;
  using Lane = BlockLanes<float, 1>;
  std::array<Lane, kBlock> factor;
  std::array<Lane, kBases> root, scale, left, change;
  float trace = 0;
  for (int k = 0; k < kept; ++k) trace += curvature[PackedLower(k, k)];
  for (int e = 0; e < PackedSize(kept); ++e) factor[e].lane[0] = curvature[e];
  for (int k = 0; k < kept; ++k) factor[PackedLower(k, k)].lane[0] += kDamping * trace / static_cast<float>(kept);
  BlockLanes<int, 1> treated{};
  FactorizeLanes<1>(kept, factor.data(), root.data(), scale.data(), left.data(), treated);
  for (int c = 0; c < 3; ++c) {
    for (int row = 0; row < kept; ++row) {
      change[row].lane[0] = 0;
      for (int col = kept; col < bases; ++col) {
        change[row].lane[0] += curvature[PackedLower(col, row)] * coefficients[3 * col + c];
      }
    }
    SolveLanes<1>(kept, factor.data(), change.data());
    for (int k = 0; k < kept; ++k) stand_in[3 * k + c] = coefficients[3 * k + c] + change[k].lane[0];
  }
}

}  // namespace

ShRemovalCost::ShRemovalCost(const splat::Model<float>& model, const ScoringViews& scoring_views)
    : count_(model.count),
      lower_(static_cast<std::size_t>(kLowerCoefficients * model.count)),
      rises_(static_cast<std::size_t>(model.count)) {
  ChooseCoefficients(model, scoring_views);
  RenderedViews rendered(model, scoring_views);
  ScoringLoss loss;
  using Rises = splat::RecolorRises<double>;
  const auto compute = [&](const View& view, Rises* rows) {
    const std::array<float, 3> centre = CentreOf(rendered.view().camera());
    const auto recolor = [&](Index i) {
      const std::array<float, kBases> basis = BasisSeen(model, i, centre);
      splat::Recolors<float> to;
      for (int d = 0; d < splat::kRecolors; ++d) {
        for (int c = 0; c < 3; ++c) {
          float color = 0.5f;
          for (int k = 0; k < ShCoefficients(d); ++k) color += basis[k] * Coefficient(i, d, 3 * k + c);
          to.color[d][c] = std::max(color, 0.0f);
        }
      }
      return to;
    };
    rendered.view().AddRecolorRises(loss.Linearize(rendered.image(), view), recolor, rows, rendered.workspace());
  };
  rendered.ForEachGathered<Rises>(compute, [&](const View&) {
    return [&](Index i, const Rises& row) {
      for (int d = 0; d < splat::kRecolors; ++d) rises_[static_cast<std::size_t>(i)].rise[d] += row.rise[d];
    };
  });
  loss_ = loss.Cost(scoring_views), values_ = loss.Values(scoring_views);
}

void ShRemovalCost::ChooseCoefficients(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  const std::vector<Curvature> curvatures = Curvatures(model, scoring_views);
  ParallelFor(model.count, kGrain, [&](Index i) {
    const int own_degree = DegreeOf(model, i), bases = ShCoefficients(own_degree);
    std::array<float, 3 * kBases> own{}, lower{};
    for (int a = 0; a < 3 * bases; ++a) own[a] = model.x[model.Offset(splat::kSh + a) + i];
    for (int degree = 0; degree < splat::kRecolors; ++degree) {
      const int kept = ShCoefficients(degree);
      lower = own;
      if (degree < own_degree) StandIn(curvatures[static_cast<std::size_t>(i)], own.data(), bases, kept, lower.data());
      for (int a = 0; a < 3 * kept; ++a) {
        lower_[static_cast<std::size_t>((FirstOf(degree) + a) * count_ + i)] = lower[a];
      }
    }
  });
}

std::vector<std::uint8_t> DegreesByAic(const splat::Model<float>& model, const ShRemovalCost& removal,
                                       double aic_weight) {
  const double unit = aic_weight * removal.loss() / removal.values();
  std::vector<std::uint8_t> degrees(static_cast<std::size_t>(model.count));
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    int best = model.DegreeOf(static_cast<Index>(i));
    double least = unit * splat::NumAttributes(best);
    for (int d = best - 1; d >= 0; --d) {
      const double total = removal.Rise(static_cast<Index>(i), d) + unit * splat::NumAttributes(d);
      if (total < least) best = d, least = total;
    }
    degrees[i] = static_cast<std::uint8_t>(best);
  }
  return degrees;
}

}  // namespace vesta::gs
