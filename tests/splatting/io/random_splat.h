// SPDX-License-Identifier: Apache-2.0
// A splat with values like those after training, because compact formats have limited ranges.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// Means within a few units, standard deviations e^-6 to e^-1, unnormalised quaternions, SH coefficients within 0.95.
inline SplatModel RandomSplat(int degree, Index count) {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return static_cast<float>(low + (high - low) * static_cast<double>(random()) / 4294967295.0);
  };
  SplatModel model;
  model.Resize(degree, count);
  const auto fill = [&](int begin, int end, double low, double high) {
    for (int a = begin; a < end; ++a) std::generate_n(model.attribute(a), count, [&] { return uniform(low, high); });
  };
  fill(splat::kMean, splat::kLogScale, -4, 4);
  fill(splat::kLogScale, splat::kQuaternion, -6, -1);
  fill(splat::kQuaternion, splat::kOpacity, -3, 3);
  fill(splat::kOpacity, splat::kSh, -4, 4);
  fill(splat::kSh, splat::kSh + 3, -2, 2);
  fill(splat::kSh + 3, model.num_attributes(), -0.95, 0.95);
  return model;
}

// Between the rotations of Gaussian i of a and j of b, radians.
inline double AngleBetween(const SplatModel& a, Index i, const SplatModel& b, Index j) {
  double product = 0, a2 = 0, b2 = 0;
  for (int k = splat::kQuaternion; k < splat::kOpacity; ++k) {
    const double p = a.attribute(k)[i], q = b.attribute(k)[j];
    product += p * q, a2 += p * p, b2 += q * q;
  }
  return 2 * std::acos(std::min(1.0, std::abs(product) / std::sqrt(a2 * b2)));
}

inline double Opacity(const SplatModel& model, Index i) {
  return 1 / (1 + std::exp(-static_cast<double>(model.attribute(splat::kOpacity)[i])));
}

// Between Gaussian order[i] of a and i of b. An empty order is the identity.
inline double LargestDifference(const SplatModel& a, const std::vector<Index>& order, const SplatModel& b,
                                int attribute) {
  double largest = 0;
  for (Index i = 0; i < b.count; ++i) {
    const Index from = order.empty() ? i : order[static_cast<std::size_t>(i)];
    largest = std::max(largest, std::abs(static_cast<double>(a.attribute(attribute)[from]) -
                                         static_cast<double>(b.attribute(attribute)[i])));
  }
  return largest;
}

}  // namespace vesta::gs
