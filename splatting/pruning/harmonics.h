// SPDX-License-Identifier: Apache-2.0
// Removal cost of the higher SH degrees of each Gaussian: the rise of the training loss when they are removed and the
// remaining coefficients are refitted.
//
// From few directions, the SH bands are nearly the same function, so the lower bands can replace most of a higher one.
// The lower coefficients are therefore refitted to the Gaussian's own colours in the views that show it. This is a
// small least-squares problem for each Gaussian and degree, weighted by the curvature of the loss. The resulting loss
// is then computed exactly, with all other Gaussians unchanged (kernels/gaussian_splatting/raster/loss_of_change.h).
// The refit ignores the gradient of the loss, because neighbours would all correct the same errors
// (docs/decisions/automatic-size.md).
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
  static constexpr int kLowerCoefficients = 42;  // for degrees 0, 1 and 2
  // Packed symmetric matrix over the coefficients of a Gaussian.
  static constexpr int kCurvatures = PackedSize(kMaxShCoefficients);

 public:
  // Bytes per Gaussian during the measurement: packed curvature, one view's contribution to it, coefficients of degrees
  // 0 to 2, and rises.
  static constexpr double kBytes =
      sizeof(float) * (kCurvatures + 1 + kLowerCoefficients) + sizeof(splat::RecolorRises<double>);
  // Takes the time of about five renderings of all views.
  ShRemovalCost(const splat::Model<float>& model, const ScoringViews& scoring_views);

  double loss() const { return loss_; }      // loss of the views, as in RemovalCost
  double values() const { return values_; }  // pixels of the views times channels
  // Rise of the loss if Gaussian i is lowered to this degree, 0..2. Negative: the loss falls. 0 if the Gaussian has no
  // higher degree.
  double Rise(Index i, int degree) const { return rises_[static_cast<std::size_t>(i)].rise[degree]; }
  // Coefficient a = 3 k + c, k < (degree + 1)^2, of Gaussian i lowered to this degree.
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

// The best degree of each Gaussian by Akaike's criterion (KeepByAic, prune.h): the degree, up to its own, that
// minimises the rise of the loss plus aic_weight times the number of parameters.
std::vector<std::uint8_t> DegreesByAic(const splat::Model<float>& model, const ShRemovalCost& removal,
                                       double aic_weight);

}  // namespace vesta::gs
