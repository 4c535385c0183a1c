// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/texture.h"

#include <numbers>

#include "demo/scene/random.h"

namespace vesta::demo {
namespace {

using std::numbers::pi;

// 0 below lo, 1 above hi, smooth in between.
double SmoothStep(double lo, double hi, double x) {
  const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// 1 within half_width of the nearest integer, 0 elsewhere, with a smooth edge of width `soft`.
double Line(double x, double half_width, double soft) {
  return 1 - SmoothStep(half_width, half_width + soft, std::abs(x - std::round(x)));
}

// The integer below x; std::floor is a function call without SSE4.1.
std::int64_t Floor(double x) {
  const auto truncated = static_cast<std::int64_t>(x);
  return truncated - (x < static_cast<double>(truncated) ? 1 : 0);
}

double Fraction(double x) { return x - static_cast<double>(Floor(x)); }

// Random in [0, 1) for each lattice point.
double LatticeValue(std::int64_t x, std::int64_t y, std::int64_t z) {
  return Uniform(Hash(0, static_cast<std::uint64_t>((x * 0x1fffff + y) * 0x1fffff + z)));
}

// Smooth noise in [0, 1] with features of size 1: interpolated lattice values.
double ValueNoise(const Vec3& p) {
  const std::int64_t x = Floor(p.x), y = Floor(p.y), z = Floor(p.z);
  const double fx = SmoothStep(0, 1, p.x - x), fy = SmoothStep(0, 1, p.y - y), fz = SmoothStep(0, 1, p.z - z);
  double layer[2];
  for (int k = 0; k < 2; ++k) {
    const double a = Mix(LatticeValue(x, y, z + k), LatticeValue(x + 1, y, z + k), fx);
    const double b = Mix(LatticeValue(x, y + 1, z + k), LatticeValue(x + 1, y + 1, z + k), fx);
    layer[k] = Mix(a, b, fy);
  }
  return Mix(layer[0], layer[1], fz);
}

// Octaves of noise, each with half the feature size and weight of the one before; about [0, 1].
double FractalNoise(const Vec3& p, int octaves) {
  double sum = 0, weight = 0.5, frequency = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += weight * ValueNoise(frequency * p + Vec3{17.0 * i, 31.0 * i, 7.0 * i});
    weight *= 0.5;
    frequency *= 2.03;
  }
  return sum;
}

Vec3 Planks(const Vec3& p) {
  constexpr double kWidth = 0.34, kLength = 1.9;
  const double across = p.x / kWidth;
  const std::int64_t row = Floor(across);
  const double along = p.z / kLength + LatticeValue(row, 0, 5);
  const double tone = LatticeValue(row, Floor(along), 3);
  const double grain = FractalNoise({p.x * 22 + 40 * tone, 9 * tone, p.z * 2.2}, 3);
  const Vec3 wood = Mix({0.36, 0.19, 0.085}, {0.62, 0.40, 0.21}, 0.55 * tone + 0.55 * grain);
  const double gap = std::max(Line(across, 0.018, 0.03), Line(along, 0.004, 0.006));
  return Mix(wood, {0.10, 0.05, 0.025}, 0.85 * gap);
}

// A round rug with rings of petals; noise imitates the weave.
Vec3 Rug(const Vec3& p) {
  const double radius = Length(p.x, p.z), angle = std::atan2(p.z, p.x) / (2 * pi);
  const Vec3 navy{0.035, 0.075, 0.17}, cream{0.80, 0.71, 0.55}, brick{0.55, 0.10, 0.065}, ochre{0.76, 0.42, 0.09};
  const Vec3 teal{0.06, 0.30, 0.31};
  const double ring = radius / 0.28;
  const int band = static_cast<int>(ring);
  const double r = Fraction(ring) - 0.5;
  const auto petals = [&](int count, double size) {
    const double a = (Fraction(angle * count) - 0.5) * 2 * pi * radius / (count * 0.28);
    return 1 - SmoothStep(size - 0.05, size + 0.05, std::sqrt(a * a + 1.6 * r * r));
  };
  Vec3 colour;
  switch (band) {
    case 0:
      colour = ochre;
      break;
    case 1:
      colour = Mix(navy, cream, petals(12, 0.33));
      break;
    case 2:
      colour = Mix(brick, ochre, petals(18, 0.30));
      break;
    case 3:
      colour = Mix(cream, teal, petals(18, 0.42));
      break;
    case 4:
      colour = Mix(navy, brick, petals(30, 0.36));
      break;
    default:
      colour = Mix(brick, cream, petals(40, 0.34));
      break;
  }
  colour = Mix(colour, cream, Line(ring, 0.07, 0.04));
  return (0.72 + 0.5 * FractalNoise(24.0 * p, 2)) * colour;
}

// Painted panels below, wallpaper above; p is on a cylinder around the vertical axis; y points down.
Vec3 Wall(const Vec3& p) {
  const double height = -p.y, angle = std::atan2(p.z, p.x) / (2 * pi);
  const double mottle = 0.85 + 0.35 * FractalNoise(2.5 * p, 3);
  if (height < 1.05) {
    const double a = Fraction(angle * 28) - 0.5, h = (height - 0.55) / 0.42;
    const double frame = std::max(std::abs(a) * 2.5, std::abs(h));
    const double moulding = SmoothStep(0.82, 0.88, frame) - SmoothStep(0.94, 1.0, frame);
    const Vec3 paint = Mix({0.10, 0.23, 0.25}, {0.17, 0.35, 0.36}, 1 - SmoothStep(0.8, 0.86, frame));
    return mottle * Mix(paint, {0.40, 0.56, 0.53}, 0.75 * moulding);
  }
  if (height < 1.15) return mottle * Vec3{0.62, 0.47, 0.26};
  const double u = angle * 56, v = (height - 1.15) / 0.56;
  const double shift = 0.5 * static_cast<double>(Floor(v) & 1);
  const double a = Fraction(u + shift) - 0.5, b = Fraction(v) - 0.5;
  const double motif = 1 - SmoothStep(0.26, 0.33, std::abs(a) * 1.15 + std::abs(b) * (0.7 + 0.6 * std::abs(a)));
  const Vec3 paper = Mix({0.74, 0.62, 0.42}, {0.66, 0.50, 0.32}, Line(u, 0.16, 0.05));
  return mottle * Mix(paper, {0.58, 0.25, 0.15}, 0.75 * motif);
}

Vec3 Marble(const Vec3& tint, const Vec3& p) {
  const double warp = FractalNoise(3.0 * p, 4);
  const double vein = 1 - std::abs(std::sin(4.2 * p.x + 3.1 * p.y + 2.3 * p.z + 9.0 * warp));
  const double cloud = FractalNoise(2.0 * p + Vec3{5, 1, 9}, 3);
  return Mix(Mix({0.86, 0.84, 0.80}, {0.70, 0.70, 0.70}, cloud), tint, std::pow(vein, 3.0));
}

// Bands around the tube of a torus in the x-z plane.
Vec3 Stripes(const Vec3& tint, const Vec3& p) {
  const double around = std::atan2(p.z, p.x) / (2 * pi);
  const double tube = std::atan2(p.y, Length(p.x, p.z) - kStripesRingRadius) / (2 * pi);
  const double t = Fraction(9 * around + tube);
  const double band = SmoothStep(0.02, 0.06, t) - SmoothStep(0.52, 0.56, t);
  return Mix({0.85, 0.80, 0.70}, tint, band);
}

// Squares of five colours with a seam between them.
Vec3 Patchwork(const Vec3& p) {
  static constexpr Vec3 kColours[] = {
      {0.72, 0.15, 0.07}, {0.84, 0.52, 0.10}, {0.10, 0.34, 0.36}, {0.82, 0.75, 0.60}, {0.08, 0.13, 0.30}};
  const Vec3 q = (1 / 0.21) * p + Vec3{0.5, 0.5, 0.5};
  const double pick = LatticeValue(Floor(q.x), Floor(q.y), Floor(q.z));
  const Vec3 colour = kColours[static_cast<int>(5 * pick)];
  // A face is perpendicular to one axis, with seams near the lattice planes of the other two.
  const double s[3] = {Line(q.x, 0.03, 0.03), Line(q.y, 0.03, 0.03), Line(q.z, 0.03, 0.03)};
  const double seam = std::max(std::max(s[0], s[1]), s[2]);
  return (0.85 + 0.3 * FractalNoise(9.0 * p, 2)) * Mix(colour, {0.9, 0.86, 0.78}, 0.8 * seam);
}

Vec3 Spiral(const Vec3& tint, const Vec3& p) {
  const double t = Fraction(3 * std::atan2(p.z, p.x) / (2 * pi) + 1.6 * p.y);
  const double band = SmoothStep(0.0, 0.05, t) - SmoothStep(0.45, 0.50, t);
  return (0.8 + 0.4 * FractalNoise(7.0 * p, 3)) * Mix({0.80, 0.72, 0.55}, tint, band);
}

// Ceramic glaze: the tint with flecks.
Vec3 Speckle(const Vec3& tint, const Vec3& p) {
  const double fleck = SmoothStep(0.62, 0.72, ValueNoise(24.0 * p));
  const double cloud = FractalNoise(5.0 * p, 3);
  return Mix((0.75 + 0.5 * cloud) * tint, {0.85, 0.80, 0.70}, 0.7 * fleck);
}

Vec3 Rings(const Vec3& tint, const Vec3& p) {
  const double growth = Length(p.x - 0.1, p.z + 0.05) + 0.06 * FractalNoise({3 * p.x, 1.2 * p.y, 3 * p.z}, 3);
  const double ring = Fraction(16 * growth);
  return (0.62 + 0.42 * ring + 0.2 * FractalNoise({30 * p.x, 2 * p.y, 30 * p.z}, 2)) * tint;
}

}  // namespace

Vec3 Albedo(Texture texture, const Vec3& tint, const Vec3& p) {
  switch (texture) {
    case Texture::kPlanks:
      return Planks(p);
    case Texture::kRug:
      return Rug(p);
    case Texture::kWall:
      return Wall(p);
    case Texture::kPlaster:
      return tint;
    case Texture::kMarble:
      return Marble(tint, p);
    case Texture::kStripes:
      return Stripes(tint, p);
    case Texture::kPatchwork:
      return Patchwork(p);
    case Texture::kSpiral:
      return Spiral(tint, p);
    case Texture::kSpeckle:
      return Speckle(tint, p);
    case Texture::kRings:
      return Rings(tint, p);
  }
  return tint;
}

}  // namespace vesta::demo
