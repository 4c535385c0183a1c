// SPDX-License-Identifier: Apache-2.0
// The Gaussian window of SSIM.
#pragma once

#include <array>

namespace vesta {

inline constexpr int kWindowRadius = 5;
inline constexpr int kWindowTaps = 2 * kWindowRadius + 1;

// Weights of one axis of the 11 x 11 Gaussian window with a standard deviation of 1.5 pixels (Wang et al. 2004, Image
// quality assessment, IEEE TIP). They sum to 1. Pixels outside the image count as zeros and the weights are not
// changed, as in the code of Kerbl et al. 2023.
std::array<double, kWindowTaps> GaussianTaps();
// Variance along one axis, in pixels squared.
double WindowVariance();

}  // namespace vesta
