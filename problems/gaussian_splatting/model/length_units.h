// In what unit of length a Gaussian's position is trained.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/types.h"
#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// The views that are looked at for it: of many only 64, evenly spread. near: distance of the near plane.
std::vector<splat::PinholeView> UnitViews(const std::vector<const View*>& views, double near);

// For each Gaussian half its depth in the nearest of the views that hold its mean beyond the depth `near`, or
// `otherwise` where none does: a learning rate for positions is then one in pixels, at most so many in any view, near
// and far alike. (Kerbl et al. 2023 have one unit for the scene.) Parallel.
std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise);

}  // namespace vesta::gs
