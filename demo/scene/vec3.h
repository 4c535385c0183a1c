// SPDX-License-Identifier: Apache-2.0
// Vectors and rotations of the ray tracer.
#pragma once

#include <algorithm>
#include <cmath>

namespace vesta::demo {

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double Dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double Length(const Vec3& a) { return std::sqrt(Dot(a, a)); }
// Length of (a, b). std::hypot, which prevents overflow, is much slower.
inline double Length(double a, double b) { return std::sqrt(a * a + b * b); }
inline Vec3 Normalized(const Vec3& a) { return (1.0 / Length(a)) * a; }
inline double Mix(double a, double b, double t) { return a + t * (b - a); }
inline Vec3 Mix(const Vec3& a, const Vec3& b, double t) { return a + t * (b - a); }

// A rotation matrix. Its rows are the axes of a frame in world coordinates. Rotate transforms from the world to the
// frame, Unrotate back.
struct Frame {
  Vec3 row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};

inline Vec3 Rotate(const Frame& f, const Vec3& v) { return {Dot(f.row[0], v), Dot(f.row[1], v), Dot(f.row[2], v)}; }
inline Vec3 Unrotate(const Frame& f, const Vec3& v) { return v.x * f.row[0] + v.y * f.row[1] + v.z * f.row[2]; }

}  // namespace vesta::demo
