// SPDX-License-Identifier: Apache-2.0
// Base class of tests that need a GPU. Otherwise they are skipped with the reason, or fail if VESTA_REQUIRE_CUDA=1.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "kernels/core/device_buffer.h"

namespace vesta::test {

class OnDevice : public testing::Test {
 protected:
  void SetUp() override {
    if (QueryDevice().usable) return;
    const char* require = std::getenv("VESTA_REQUIRE_CUDA");
    ASSERT_FALSE(require != nullptr && std::string_view(require) == "1")
        << "VESTA_REQUIRE_CUDA=1, but no GPU: " << QueryDevice().name;
    GTEST_SKIP() << "no GPU on this machine: " << QueryDevice().name;
  }
};

template <class T>
HostSpan<const T> ViewOf(const std::vector<T>& v) {
  return {v.data(), static_cast<Index>(v.size())};
}
template <class T>
DeviceBuffer<T> ToDevice(const std::vector<T>& v) {
  DeviceBuffer<T> buffer;
  buffer.CopyFrom(ViewOf(v));
  return buffer;
}
template <class T>
std::vector<T> ToHost(const DeviceBuffer<T>& buffer) {
  std::vector<T> v(static_cast<std::size_t>(buffer.size()));
  buffer.CopyTo({v.data(), buffer.size()});
  return v;
}

// |a - b| / |b|; NaN fails every comparison.
template <class A, class E>
double RelativeError(const A& a, const E& b) {
  double difference = 0, size = 0;
  auto at = a.begin();
  for (const auto value : b) {
    const double d = static_cast<double>(*at++) - static_cast<double>(value);
    difference += d * d;
    size += static_cast<double>(value) * static_cast<double>(value);
  }
  return std::sqrt(difference / std::max(size, 1e-300));
}

}  // namespace vesta::test
