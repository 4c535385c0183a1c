// SPDX-License-Identifier: Apache-2.0
// How strongly an image pulls at the place of a splat: the norm of the view-space positional gradient, the score of
// adaptive density control (Kerbl et al. 2023, section 5.2). In normalised device coordinates; called its pull.
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/formulas/project.h"

namespace vesta::gs {
inline namespace VESTA_ISA {

// |d loss / d (u, v)| with u in units of half_width and v of half_height pixels. w: the splat's cotangent.
VESTA_HD inline float ScreenPull(const splat::Splat<float>& splat, const float* w, float half_width,
                                 float half_height) {
  using std::hypot;
  float by_u, by_v;
  splat::ScreenMeanAdjoint(splat.r, splat.s, splat.beta, w, by_u, by_v);
  return hypot(by_u * half_width, by_v * half_height);
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
