#include "tests/kernels/math/falloff_exp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/cpu_isas.h"

namespace vesta {
namespace {

void RunExp(Isa isa, const float* x, float* y, int count) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::kAvx512:
      return avx512::FalloffExpArray(x, y, count);
    case Isa::kAvx2:
      return avx2::FalloffExpArray(x, y, count);
#endif
    default:
      return baseline::FalloffExpArray(x, y, count);
  }
}

// The greatest relative error at 2^20 points of [lo, 0].
double WorstError(Isa isa, double lo) {
  constexpr int kCount = 1 << 20;
  std::vector<float> x(kCount), y(kCount);
  for (int i = 0; i < kCount; ++i) x[static_cast<std::size_t>(i)] = static_cast<float>(lo * i / (kCount - 1));
  RunExp(isa, x.data(), y.data(), kCount);
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double exact = std::exp(static_cast<double>(x[i]));
    worst = std::max(worst, std::abs(y[i] - exact) / exact);
  }
  return worst;
}

TEST(FalloffExp, AgreesWithTheStandardLibraryOverItsRange) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    // ln(1/255) = -5.54 is where alpha ends for opacity 1; the rest is never blended.
    EXPECT_LE(WorstError(isa, -6), 5e-7);
    EXPECT_LE(WorstError(isa, -17), 1e-6);
    EXPECT_LE(WorstError(isa, -87), 1e-6);
  }
}

TEST(FalloffExp, IsOneAtZeroAndVanishesFarOut) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    const float x[16] = {0.0f, -0.0f, -87.0f, -88.0f, -100.0f, -1e4f, -1e30f, -HUGE_VALF};
    float y[16];
    RunExp(isa, x, y, 16);
    EXPECT_NEAR(y[0], 1, 1.2e-7);
    EXPECT_NEAR(y[1], 1, 1.2e-7);
    for (int i = 2; i < 8; ++i) {
      EXPECT_GE(y[i], 0) << x[i];
      EXPECT_LE(y[i], 1.7e-38) << x[i];
    }
  }
}

}  // namespace
}  // namespace vesta
