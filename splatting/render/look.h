// Where the cameras of a scene look, and cameras that look somewhere.
#pragma once

#include <array>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

using Point3 = std::array<double, 3>;

// The view from `center` towards `target`, with `up` upwards in its image, or anything where it looks along that.
// target and center differ.
View LookingAt(const Camera& camera, const Point3& center, const Point3& target, const Point3& up);

// The mean of the directions that the views look in, world axes: 1 long where all look one way, 0 where they look
// everywhere.
Point3 MeanDirection(const std::vector<View>& views);

// The direction, of length 1, across the rows of the views' images that is upwards in them on the whole: vertical, as
// far as cameras are held level. For cameras that look down at all turns it is what is behind them.
Point3 UpOf(const std::vector<View>& views);

// The point nearest to the optical axes of the views, by least squares. What parallel axes leave open is decided by the
// scene's extent: the median depth before the middle of the cameras.
Point3 PointLookedAt(const Scene& scene);

}  // namespace vesta::gs
