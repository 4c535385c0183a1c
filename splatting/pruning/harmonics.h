// SPDX-License-Identifier: Apache-2.0
// What the higher degrees of each Gaussian's spherical harmonics are worth to the training views: by how much their
// cost rises when they go and the coefficients that stay stand in for them.
//
// Seen from few sides, the bands are nearly the same function, and most of what a band does the lower ones can do. So
// the coefficients of the lower degree are those whose colours, in the views that show the Gaussian, are nearest to its
// own, differences weighed by the curvature of the cost (least squares: one small system for each Gaussian and degree).
// What then becomes of the cost is asked of the cost itself, exactly
// (kernels/gaussian_splatting/raster/loss_of_change.h), all other Gaussians being as they are. Coefficients do not
// follow the slope of the cost: neighbours would all correct the same errors (docs/decisions/automatic-size.md).
#pragma once

#include <array>
#include <vector>

#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/raster/loss_of_change.h"
#include "kernels/math/spherical_harmonics.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

class ShRemovalCost {
  static constexpr int kLowerCoefficients = 42;  // of degrees 0, 1 and 2
  // Half of a symmetric matrix of as many rows as a Gaussian has coefficients.
  static constexpr int kCurvatures = PackedSize(kMaxShCoefficients);

 public:
  // Bytes for each Gaussian while it is measured: its packed curvature and one view's term of that, coefficients of
  // degrees 0 to 2, rises.
  static constexpr double kBytes =
      sizeof(float) * (kCurvatures + 1 + kLowerCoefficients) + sizeof(splat::RecolorRises<double>);
  // Takes about five times as long as rendering all views.
  ShRemovalCost(const splat::Model<float>& model, const ScoringViews& judges);

  double cost() const { return cost_; }      // of the views, as in RemovalCost
  double values() const { return values_; }  // pixels of the views, by channel
  // Of the cost, when Gaussian i is lowered to this degree, 0..2; negative: better so. 0 where it has no higher one.
  double Rise(Index i, int degree) const { return rises_[static_cast<std::size_t>(i)].rise[degree]; }
  // Coefficient a = 3 k + c, k < (degree + 1)^2, of Gaussian i when it is lowered to this degree.
  float Coefficient(Index i, int degree, int a) const {
    return lower_[static_cast<std::size_t>((FirstOf(degree) + a) * count_ + i)];
  }

 private:
  static constexpr int FirstOf(int degree) { return degree == 0 ? 0 : degree == 1 ? 3 : 15; }

  void ChooseCoefficients(const splat::Model<float>& model, const ScoringViews& judges);

  Index count_;
  double cost_ = 0, values_ = 0;
  std::vector<float> lower_;
  std::vector<splat::RecolorRises<double>> rises_;
};

// The degree of each Gaussian that pays for its parameters (KeepByAic, prune.h): of all up to its own the one for
// which the rise of the cost and the aic_weight of the coefficients are together the least.
std::vector<std::uint8_t> DegreesByAic(const splat::Model<float>& model, const ShRemovalCost& worth, double aic_weight);

}  // namespace vesta::gs
