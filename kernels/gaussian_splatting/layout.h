// The order of a Gaussian's parameters. The table of the project: everything else asks here.
//
// A model is one structure of arrays: attribute a of Gaussian i is x[a * count + i], with
//   a  0..2   mean, world units
//   a  3..5   log of the standard deviations along the principal axes
//   a  6..9   quaternion w, x, y, z, not normalised
//   a  10     opacity, logit
//   a  11 + 3 k + c   spherical-harmonics coefficient k of channel c (red, green, blue), k < (degree + 1)^2
#pragma once

namespace vesta::splat {

inline constexpr int kMean = 0;
inline constexpr int kLogScale = 3;
inline constexpr int kQuaternion = 6;
inline constexpr int kOpacity = 10;
inline constexpr int kSh = 11;        // also the number of geometric attributes
inline constexpr int kGeometry = 11;  // mean, log-scale, quaternion, opacity: one block of the preconditioner
inline constexpr int kMaxAttributes = kSh + 48;

constexpr int NumAttributes(int sh_degree) { return kSh + 3 * (sh_degree + 1) * (sh_degree + 1); }

}  // namespace vesta::splat
