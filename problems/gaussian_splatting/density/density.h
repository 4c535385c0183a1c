// Adaptive density control: where the images pull a Gaussian's mean about, clone it if small and split it if large;
// drop what is transparent or huge (Kerbl et al. 2023, section 5.2).
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/view.h"
#include "problems/gaussian_splatting/adam/adam.h"
#include "problems/gaussian_splatting/density/density_formula.h"

namespace vesta::gs {

class DensityControl {
 public:
  DensityControl(const DensityOptions& options, double extent, std::uint64_t seed, Index count);

  // After the gradient of one view: splat_cotangents by rank (ViewWorkspace::splat_sums), of the loss times loss_scale.
  void Observe(const splat::View<float>& view, const splat::SplatTangent<float>* splat_cotangents, double loss_scale);

  // What was observed, by Gaussian: the sum of the pulls and the number of observations.
  std::vector<float>& pull() { return pull_; }
  std::vector<int>& seen() { return seen_; }

  // Forgets what was observed; of a model of so many Gaussians from now on.
  void Forget(Index count);
  // Clones, splits and prunes; iteration keys the random offsets of split Gaussians. Never leaves more than
  // max_gaussians (the strongest candidates come first) and never none. Forgets what was observed.
  void Densify(SplatModel& model, Adam& adam, int iteration);
  // Opacities come down to 0.01 where they are higher.
  static void ResetOpacity(SplatModel& model, Adam& adam);

 private:
  std::vector<Fate> Decide(const SplatModel& model) const;

  DensityOptions options_;
  double extent_;
  std::uint64_t seed_;
  std::vector<float> pull_;  // sum over observations of |d loss / d mean| in normalised device coordinates
  std::vector<int> seen_;
};

}  // namespace vesta::gs
