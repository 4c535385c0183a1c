// Photographs without the radial distortion that their lens is found to have still: of a lens whose coefficients were
// wrong when the photograph was undistorted, it shows a pinhole's image bent about the principal point. What belongs at
// a distance of r focal lengths is seen a factor 1 + k1 r^2 + k2 r^4 farther out.
#pragma once

#include <array>

#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

using RadialCoefficients = std::array<double, 2>;  // k1, k2

// How much farther out something is seen, r2 = r^2.
inline double BendFactor(const double radial[2], double r2) { return 1 + r2 * (radial[0] + r2 * radial[1]); }

// How far the farthest corner of the image is from the principal point, in focal lengths.
double CornerOf(const Camera& camera);

// How far the bend moves that corner, pixels.
double CornerBend(const Camera& camera, const double radial[2]);

// The coefficients to the nearest that move the corner by whole fifths of a pixel: so photographs are not made anew
// for steps that nobody would see.
RadialCoefficients Visible(const Camera& camera, const double radial[2]);

// The camera's photograph as a pinhole would show it, with a mask: what would be seen beyond its border takes no part.
Image Unbent(const Image& photograph, const Camera& camera, const RadialCoefficients& radial);

}  // namespace vesta::gs
