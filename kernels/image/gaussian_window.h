// SPDX-License-Identifier: Apache-2.0
// The window of SSIM.
#pragma once

#include <array>

namespace vesta {

inline constexpr int kWindowRadius = 5;
inline constexpr int kWindowTaps = 2 * kWindowRadius + 1;

// Weights of one axis of the 11 x 11 Gaussian window of standard deviation 1.5 pixels (Wang et al., Image quality
// assessment, IEEE TIP 2004); they sum to 1. Pixels outside the image count as zeros with their weight kept, as in the
// code of Kerbl et al. 2023, so the window of a border pixel sums to less than 1.
std::array<double, kWindowTaps> GaussianTaps();
// Along one axis, pixels squared.
double WindowVariance();

}  // namespace vesta
