// SPDX-License-Identifier: Apache-2.0
// Removal cost of the higher SH degrees: the rise of the training loss when they are removed and the remaining
// coefficients are refitted.
//
// For a Gaussian that is seen from few directions, lower SH bands can replace most of a higher one. The lower
// coefficients are refitted to the Gaussian's colours in the views that show it: a small least-squares problem per
// Gaussian and degree, weighted by the curvature of the loss. The rise of the loss is then predicted with all other
// Gaussians unchanged (kernels/gaussian_splatting/raster/loss_of_change.h). The refit does not aim at a lower loss,
// because neighbouring Gaussians would all correct the same errors (docs/decisions/automatic-size.md).
#pragma once

#include <array>
#include <vector>

#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/raster/loss_of_change.h"
#include "kernels/math/spherical_harmonics.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

// Predictions for each Gaussian and each SH degree below its own.
class ShRemovalCost {
  static constexpr int kLowerCoefficients = 42;  // for degrees 0, 1 and 2
  // Packed symmetric matrix over a Gaussian's coefficients.
  static constexpr int kCurvatures = PackedSize(kMaxShCoefficients);

 public:
  // Bytes per Gaussian for the constructor: packed curvature, one view's contribution to it, coefficients of degrees 0
  // to 2, and rises.
  static constexpr double kBytes =
      sizeof(float) * (kCurvatures + 1 + kLowerCoefficients) + sizeof(splat::RecolorRises<double>);
  // Takes the time of about five renderings of all views. Collective.
  ShRemovalCost(const splat::Model<float>& model, const ScoringViews& scoring_views);

  double loss() const { return loss_; }      // loss of the views, as in RemovalCost
  double values() const { return values_; }  // pixels of the views times channels
  // Rise of the loss if Gaussian i is lowered to this degree, 0..2; 0 if its degree is not higher. May be negative.
  double Rise(Index i, int degree) const { return rises_[static_cast<std::size_t>(i)].rise[degree]; }
  // Refitted SH coefficient of Gaussian i: a = 3 k + c for basis function k < (degree + 1)^2 and channel c.
  float Coefficient(Index i, int degree, int a) const {
    return lower_[static_cast<std::size_t>((FirstOf(degree) + a) * count_ + i)];
  }

 private:
  static constexpr int FirstOf(int degree) { return degree == 0 ? 0 : degree == 1 ? 3 : 15; }

  void ChooseCoefficients(const splat::Model<float>& model, const ScoringViews& scoring_views);

  Index count_;
  double loss_ = 0, values_ = 0;
  std::vector<float> lower_;
  std::vector<splat::RecolorRises<double>> rises_;
};

// The best degree of each Gaussian by Akaike's information criterion (KeepByAic, prune.h): it minimises the rise of the
// loss plus aic_weight * loss / n times the number of parameters; n is ShRemovalCost::values().
std::vector<std::uint8_t> DegreesByAic(const splat::Model<float>& model, const ShRemovalCost& removal,
                                       double aic_weight);

}  // namespace vesta::gs
