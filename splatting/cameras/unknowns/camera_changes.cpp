// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/camera_changes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/scene/camera_rig.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {

CameraChanges ChangesOf(const SplatModel& model, const std::vector<const View*>& given,
                        const std::vector<ViewUnknowns>& found, double near) {
  VESTA_CHECK(given.size() == found.size(), "{} views, {} of which something was found", given.size(), found.size());
  CameraChanges changes;
  std::vector<double> degrees, pixels;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const splat::CameraMotion& motion = found[i].motion;
    degrees.push_back(motion.Angle() * 180 / std::numbers::pi);
    // Most trainings leave most cameras where they are.
    const bool is_still = degrees.back() == 0 && found[i].lens.is_none() &&
                          std::ranges::all_of(motion.translation, [](double t) { return t == 0; });
    pixels.push_back(is_still ? 0 : MedianShift(model, *given[i], AsFound(*given[i], found[i]), near));
    changes.most_pixels = std::max(changes.most_pixels, pixels.back());
    for (const double log_focal : found[i].lens.log_focal) {
      changes.most_focal = std::max(changes.most_focal, std::abs(std::exp(log_focal) - 1));
    }
    for (const double gain : found[i].color.gain) changes.most_gain = std::max(changes.most_gain, std::abs(gain - 1));
  }
  if (given.empty()) return changes;
  changes.degrees = Median(std::move(degrees));
  changes.pixels = Median(std::move(pixels));
  return changes;
}

}  // namespace vesta::gs
