// In what unit of length a Gaussian's position is trained.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/io/scene.h"

namespace vesta::gs {

// For each Gaussian half its depth in the nearest of the views that hold its mean beyond the depth `near`, or
// `otherwise` where none does: a learning rate for positions is then one in pixels, at most so many in any view, near
// and far alike. (Kerbl et al. 2023 have one unit for the scene.) Of many views only 64 are looked at, evenly spread.
// Parallel.
std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise);

}  // namespace vesta::gs
