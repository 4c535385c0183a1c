// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "tests/kernels/math/lane_functions.h"
#include "tests/support/cpu_isas.h"

namespace vesta {

VESTA_DECLARE_PER_ISA(LaneFunctions CompiledLaneFunctions();)

namespace {

LaneFunctions LaneFunctionsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledLaneFunctions)(); }

// Largest relative error of 2^x at 2^20 points of [lo, 0].
double WorstError(const LaneFunctions& lanes, double lo) {
  constexpr int kCount = 1 << 20;
  std::vector<float> x(kCount), y(kCount);
  const auto mask = std::make_unique<bool[]>(kCount);
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = static_cast<float>(lo * static_cast<double>(i) / (kCount - 1));
    mask[i] = true;
  }
  lanes.masked_exp2(x.data(), mask.get(), y.data(), kCount);
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double exact = std::exp2(static_cast<double>(x[i]));
    worst = std::max(worst, std::abs(y[i] - exact) / exact);
  }
  return worst;
}

TEST(Lanes, Exp2AgreesWithTheStandardLibraryOverItsRange) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    // At opacity 1, alpha ends at log2(1/255) = -7.99; smaller values are not blended.
    EXPECT_LE(WorstError(LaneFunctionsFor(isa), -8), 3e-7);
    EXPECT_LE(WorstError(LaneFunctionsFor(isa), -126), 5e-7);
  }
}

TEST(Lanes, Exp2IsOneAtZeroAndZeroWhereMasked) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    const float x[16] = {0.0f, -0.0f, -1.0f, -126.0f, -127.0f, -1e4f, -1e30f, -HUGE_VALF, NAN, 0.0f, 1e30f, HUGE_VALF};
    const bool mask[16] = {true, true, true, true};
    float y[16];
    LaneFunctionsFor(isa).masked_exp2(x, mask, y, 16);
    EXPECT_NEAR(y[0], 1, 1.2e-7);
    EXPECT_NEAR(y[1], 1, 1.2e-7);
    EXPECT_NEAR(y[2], 0.5, 1e-7);
    EXPECT_NEAR(y[3], 0x1p-126, 0x1p-126 * 1e-6);
    for (int i = 4; i < 16; ++i) EXPECT_EQ(y[i], 0) << x[i];
  }
}

TEST(Lanes, ExpAgreesWithTheStandardLibrary) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    constexpr int kCount = 1 << 20;
    std::vector<float> x(kCount), y(kCount);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(-86 + 174 * static_cast<double>(i) / kCount);
    LaneFunctionsFor(isa).exp(x.data(), y.data(), kCount);
    double worst = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      worst = std::max(worst, std::abs(y[i] / std::exp(static_cast<double>(x[i])) - 1));
    }
    EXPECT_LE(worst, 2e-7);
    const float ends[16] = {0.0f, -0.0f, -110.0f, -1e30f, -HUGE_VALF, 90.0f, 1e30f, HUGE_VALF, NAN, 88.0f};
    float of_ends[16];
    LaneFunctionsFor(isa).exp(ends, of_ends, 16);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(of_ends[i], 1);
    for (int i = 2; i < 5; ++i) EXPECT_EQ(of_ends[i], 0) << ends[i];
    for (int i = 5; i < 8; ++i) EXPECT_EQ(of_ends[i], HUGE_VALF) << ends[i];
    EXPECT_TRUE(std::isnan(of_ends[8]));
    EXPECT_NEAR(of_ends[9] / std::exp(88.0), 1, 2e-7);
  }
}

TEST(Lanes, ReciprocalAgreesWithDivisionOverItsRange) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    constexpr int kCount = 1 << 20;
    std::vector<float> x(kCount), y(kCount);
    for (std::size_t i = 0; i < x.size(); ++i) {
      // From 2^-100 to 2^100, all mantissas, both signs.
      x[i] = static_cast<float>(std::exp2(-100 + 200 * static_cast<double>(i) / kCount)) * (i % 2 == 0 ? 1.0f : -1.0f);
    }
    LaneFunctionsFor(isa).reciprocal(x.data(), y.data(), kCount);
    double worst = 0;
    for (std::size_t i = 0; i < x.size(); ++i) worst = std::max(worst, std::abs(static_cast<double>(y[i]) * x[i] - 1));
    EXPECT_LE(worst, 3e-7);
  }
}

TEST(Lanes, SquareRootAgreesWithTheStandardLibraryAndIsZeroWhereMasked) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    constexpr int kCount = 1 << 16;
    std::vector<float> x(kCount), y(kCount);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = static_cast<float>(std::exp2(-100 + 200 * static_cast<double>(i) / kCount)) * (i % 8 == 0 ? -1.0f : 1.0f);
    }
    x[0] = 0;
    LaneFunctionsFor(isa).square_root(x.data(), y.data(), kCount);
    double worst = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (i % 8 == 0) {
        EXPECT_EQ(y[i], 0) << x[i];
      } else {
        worst = std::max(worst, std::abs(y[i] / std::sqrt(static_cast<double>(x[i])) - 1));
      }
    }
    EXPECT_LE(worst, 7e-5);
  }
}

TEST(Lanes, AppendSetBitsListsThemAscending) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    for (const std::uint32_t bits : {0U, 1U, 0x8000U, 0xFFFFU, 0xA5A5U, 0x0180U}) {
      std::uint32_t out[17];
      out[16] = 77;
      const int count = LaneFunctionsFor(isa).append_set_bits(bits, 100, out);
      int at = 0;
      for (std::uint32_t bit = 0; bit < 16; ++bit) {
        if ((bits >> bit & 1U) == 0) continue;
        EXPECT_EQ(out[at++], 100 + bit);
      }
      EXPECT_EQ(count, at);
      EXPECT_EQ(out[16], 77U) << "written past the sixteenth";
    }
  }
}

TEST(Lanes, SumEachAddsTheLanesOfEachVector) {
  for (const Isa isa : test::CpuIsas()) {
    const LaneFunctions lanes = LaneFunctionsFor(isa);
    std::vector<float> x(static_cast<std::size_t>(36 * lanes.width));
    // Integers make sums exact in any order.
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(i * i % 1009);
    for (const int n : {1, 3, 9, 15, 16, 18, 36}) {
      SCOPED_TRACE(testing::Message() << IsaName(isa) << ", " << n << " vectors");
      std::vector<float> sums(static_cast<std::size_t>(n) + 1, -1.0f);
      lanes.sum_each(x.data(), n, sums.data());
      for (int k = 0; k < n; ++k) {
        float expected = 0;
        for (int i = 0; i < lanes.width; ++i) expected += x[static_cast<std::size_t>(Index{k} * lanes.width + i)];
        EXPECT_EQ(sums[static_cast<std::size_t>(k)], expected) << k;
      }
      EXPECT_EQ(sums.back(), -1) << "written past the end";
    }
  }
}

TEST(Lanes, BitsAreInTheOrderOfTheLanes) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    const LaneFunctions lanes = LaneFunctionsFor(isa);
    for (int lane = 0; lane < lanes.width; ++lane) {
      std::vector<float> x(16, 0.0f);
      x[static_cast<std::size_t>(lane)] = 1;
      EXPECT_EQ(lanes.positive_bits(x.data()), 1U << lane);
    }
  }
}

}  // namespace
}  // namespace vesta
