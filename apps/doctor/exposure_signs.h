// How light each photograph is, where it shows what others show too.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Of each view, in stops (factors of two of light, by luma^2.2) beside the median view: the median over the points that
// lie in its image of how much lighter its pixel is than the point's colour, which is the mean of all photographs that
// found it. So it tells the exposure, not what the picture is of. 0 where the quarters
// of its points do not agree which way: then things before the points are seen. NaN with fewer than 20 of them.
std::vector<double> ExposureStops(const gs::Scene& scene);

}  // namespace vesta::app
