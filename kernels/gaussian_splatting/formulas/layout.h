// SPDX-License-Identifier: Apache-2.0
// The parameters (attributes) of a Gaussian and their memory layout. a is the index of an attribute:
//
//   a  0..2   mean, world units
//   a  3..5   log of the standard deviations along the principal axes
//   a  6..9   quaternion w, x, y, z, not normalised
//   a  10     opacity, logit
//   a  11 + 3 k + c   spherical-harmonics coefficient k of channel c (red, green, blue), k < (degree + 1)^2
//
// A model is one structure of arrays. Each Gaussian has its own SH degree. Gaussians are sorted by degree, highest
// first, so an SH band is stored only for the first Gaussians. Attribute a of Gaussian i is x[Offset(a) + i]
// (ModelLayout). If all Gaussians have the same degree, this is x[a * count + i].
#pragma once

#include <cstdint>

#include "kernels/core/hd.h"

namespace vesta::splat {

inline constexpr int kMean = 0;
inline constexpr int kLogScale = 3;
inline constexpr int kQuaternion = 6;
inline constexpr int kOpacity = 10;
inline constexpr int kSh = 11;        // also the number of geometric attributes
inline constexpr int kGeometry = 11;  // mean, log-scale, quaternion, opacity: one block of the preconditioner
inline constexpr int kMaxShDegree = 3;
inline constexpr int kMaxAttributes = kSh + 48;

VESTA_HD constexpr int NumAttributes(int sh_degree) { return kSh + 3 * (sh_degree + 1) * (sh_degree + 1); }
// Number of SH coefficients above degree 0 in all three channels, 0..45.
VESTA_HD constexpr int NumHigherHarmonics(int sh_degree) { return NumAttributes(sh_degree) - NumAttributes(0); }
// Band b, 0..3, has the attributes FirstOfBand(b) to NumAttributes(b) - 1. The geometry is part of band 0.
VESTA_HD constexpr int FirstOfBand(int band) { return band == 0 ? 0 : NumAttributes(band - 1); }
VESTA_HD constexpr int BandOf(int attribute) {
  int band = 0;
  for (int b = 1; b <= kMaxShDegree; ++b) band += attribute >= FirstOfBand(b) ? 1 : 0;
  return band;
}

struct ModelLayout {
  std::int64_t count = 0;  // Gaussians
  int sh_degree = 0;       // 0..3, the highest of all Gaussians
  // without_band[b - 1]: number of Gaussians, always the last ones, without SH band b = 1, 2, 3. 0 if b > sh_degree.
  std::int64_t without_band[kMaxShDegree] = {};

  // Number of Gaussians with this band, 0..3. They are the first Gaussians.
  VESTA_HD constexpr std::int64_t WithBand(int band) const {
    if (band > sh_degree) return 0;
    return band == 0 ? count : count - without_band[band - 1];
  }
  VESTA_HD constexpr std::int64_t Rows(int attribute) const { return WithBand(BandOf(attribute)); }
  // Index of the first value of the attribute; Size() for attributes that no Gaussian has.
  VESTA_HD constexpr std::int64_t Offset(int attribute) const {
    std::int64_t offset = attribute * count;
    for (int band = 1; band <= kMaxShDegree; ++band) {
      const int first = FirstOfBand(band), end = NumAttributes(band);
      if (attribute > first) offset -= ((attribute < end ? attribute : end) - first) * (count - WithBand(band));
    }
    return offset;
  }
  constexpr std::int64_t Size() const { return Offset(kMaxAttributes); }
  constexpr int DegreeOf(std::int64_t gaussian) const {
    int degree = sh_degree;
    while (gaussian >= WithBand(degree)) --degree;
    return degree;
  }
  constexpr bool is_uniform() const { return WithBand(sh_degree) == count; }
  friend constexpr bool operator==(const ModelLayout&, const ModelLayout&) = default;

  // Whether a layout read from a file is valid.
  constexpr bool IsValid() const {
    constexpr std::int64_t kMaxCount = std::int64_t{1} << 40;  // beyond it, sizes would overflow
    if (sh_degree < 0 || sh_degree > kMaxShDegree || count < 1 || count > kMaxCount) return false;
    std::int64_t below = 0;
    for (int band = 1; band <= kMaxShDegree; ++band) {
      const std::int64_t lack = without_band[band - 1];
      if (band > sh_degree ? lack != 0 : lack < below || lack >= count) return false;
      below = lack;
    }
    return true;
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(sh_degree, count, without_band);
  }
};

// The layout of a model in which with_band[b] Gaussians have band b = 0..3. with_band[b] must not increase with b.
constexpr ModelLayout LayoutOfBands(const std::int64_t (&with_band)[kMaxShDegree + 1]) {
  ModelLayout layout{.count = with_band[0]};
  for (int band = 1; band <= kMaxShDegree && with_band[band] > 0; ++band) {
    layout.sh_degree = band;
    layout.without_band[band - 1] = with_band[0] - with_band[band];
  }
  return layout;
}

}  // namespace vesta::splat
