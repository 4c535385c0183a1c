// Adaptive density control: where the images pull a Gaussian's mean about, clone it if small and split it if large;
// drop what is transparent or huge (Kerbl et al. 2023, section 5.2).
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/gaussian_splatting/view.h"
#include "problems/gaussian_splatting/train/adam.h"

namespace vesta::gs {

class DensityControl {
 public:
  DensityControl(const DensityOptions& options, double extent, std::uint64_t seed, Index count);

  // After the gradient of one view: splat_cotangents by rank (ViewWorkspace::splat_sums), of the loss times loss_scale.
  void Observe(const splat::View<float>& view, const splat::SplatTangent<float>* splat_cotangents, double loss_scale);

  // What was observed, by Gaussian: the sum of the pulls and the number of observations. A device that observes in the
  // place of this object takes them along and brings them back.
  std::vector<float>& pull() { return pull_; }
  std::vector<int>& seen() { return seen_; }

  // From now on at most so many, where that is fewer.
  void LimitGaussians(Index most) { options_.max_gaussians = std::min(options_.max_gaussians, most); }
  // Forgets what was observed; of a model of so many Gaussians from now on.
  void Forget(Index count);
  // Clones, splits and prunes; iteration keys the random offsets of split Gaussians. Never leaves more than
  // max_gaussians (the strongest candidates come first) and never none. Forgets what was observed.
  void Densify(SplatModel& model, Adam& adam, int iteration);
  // Opacities come down to 0.01 where they are higher.
  static void ResetOpacity(SplatModel& model, Adam& adam);

 private:
  enum class Fate { kKeep, kPrune, kClone, kSplit };
  std::vector<Fate> Decide(const SplatModel& model) const;

  DensityOptions options_;
  double extent_;
  std::uint64_t seed_;
  std::vector<float> pull_;  // sum over observations of |d loss / d mean| in normalised device coordinates
  std::vector<int> seen_;
};

}  // namespace vesta::gs
