// SPDX-License-Identifier: Apache-2.0
// Lens distortion models, as in COLMAP and OpenCV. Training uses pinhole cameras only; photographs are undistorted on
// loading (undistort.h).
//
// Formulas: COLMAP, src/colmap/sensor/models.h (SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV; OPENCV_FISHEYE and its
// special cases SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE); OpenCV's documentation, "Camera Calibration and 3D
// Reconstruction" and "Fisheye camera model". Each is stored as FULL_OPENCV or OPENCV_FISHEYE, with zeros for missing
// coefficients.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/math/dual.h"

namespace vesta::gs {

// Dimensionless coefficients for x/z and y/z in camera coordinates. Default: no distortion.
struct Distortion {
  bool is_fisheye = false;
  std::array<double, 6> radial{};      // k1 .. k6; fisheye: k1 .. k4, for powers of the angle from the axis
  std::array<double, 2> tangential{};  // p1, p2; not used by fisheye

  bool operator==(const Distortion&) const = default;
  // A fisheye is never a pinhole, even if its coefficients are zero.
  bool is_none() const { return *this == Distortion{}; }
  bool is_finite() const {
    const auto finite = [](double value) { return std::isfinite(value); };
    return std::all_of(radial.begin(), radial.end(), finite) &&
           std::all_of(tangential.begin(), tangential.end(), finite);
  }
};

// Image position of the direction (x, y, 1) for focal length 1, relative to the principal point. Without distortion it
// is (x, y).
template <class T>
std::array<T, 2> Distort(const Distortion& lens, const T& x, const T& y) {
  using std::atan;
  using std::sqrt;
  const auto& k = lens.radial;
  const T r2 = x * x + y * y;
  if (lens.is_fisheye) {
    constexpr double kNear = 1e-10;  // below this, atan(r) / r is 1 - r²/3 to the last bit
    T angle2 = r2, shrink = T(1) - r2 / T(3);
    if (r2 > T(kNear)) {
      const T r = sqrt(r2), angle = atan(r);
      angle2 = angle * angle;
      shrink = angle / r;
    }
    const T scale = shrink * (T(1) + angle2 * (T(k[0]) + angle2 * (T(k[1]) + angle2 * (T(k[2]) + angle2 * T(k[3])))));
    return {x * scale, y * scale};
  }
  const T scale =
      (T(1) + r2 * (T(k[0]) + r2 * (T(k[1]) + r2 * T(k[2])))) / (T(1) + r2 * (T(k[3]) + r2 * (T(k[4]) + r2 * T(k[5]))));
  const T p1 = T(lens.tangential[0]), p2 = T(lens.tangential[1]), two(2), xy = two * x * y;
  return {x * scale + p1 * xy + p2 * (r2 + two * x * x), y * scale + p2 * xy + p1 * (r2 + two * y * y)};
}

// Derivative of Distort at (x, y), row-major: d x'/dx, d x'/dy, d y'/dx, d y'/dy.
inline std::array<double, 4> DistortionJacobian(const Distortion& lens, double x, double y) {
  using D = Dual<double>;
  const std::array<D, 2> by_x = Distort(lens, D(x, 1), D(y, 0)), by_y = Distort(lens, D(x, 0), D(y, 1));
  return {by_x[0].v, by_y[0].v, by_x[1].v, by_y[1].v};
}

}  // namespace vesta::gs
