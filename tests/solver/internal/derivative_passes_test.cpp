// SPDX-License-Identifier: Apache-2.0
// Derivatives with respect to many parameters, which take several evaluations of the functor.
#include "solver/internal/derivative_passes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "solver/cost_function.h"
#include "solver/residual_blocks.h"
#include "tests/support/linearize_at.h"

namespace vesta {
namespace {

// Number of calls of the functors below for each type of number. The tests run on one thread each.
struct Calls {
  int values = 0, derivatives = 0;
};

// Two residuals that depend on all parameters in different ways; undefined for negative p[0].
template <int kCount>
struct Waves {
  static constexpr int kResiduals = 2, kParameters = kCount;
  Calls* calls = nullptr;

  template <class T>
  bool operator()(const T* p, T* r) const {
    using std::sin;
    if (calls != nullptr) ++(sizeof(T) <= sizeof(double) ? calls->values : calls->derivatives);
    r[0] = r[1] = T(0.25f);
    for (int i = 0; i < kCount; ++i) {
      r[0] += sin(p[i] * T(static_cast<float>(i + 1) * 0.125f));
      r[1] = r[1] * T(0.5f) + p[i] * p[(i + 1) % kCount];
    }
    return !(p[0] < T(0.0f));
  }
};

template <class S>
S Parameter(int i) {
  return static_cast<S>(0.5 + 0.25 * std::sin(1.0 + i));
}

// Derivative of residual k with respect to parameter c, one at a time.
template <class F, class S>
S Expected(const F& functor, int k, int c) {
  std::vector<Dual<S>> p(F::kParameters), r(F::kResiduals);
  for (int i = 0; i < F::kParameters; ++i) p[i] = Dual<S>(Parameter<S>(i), i == c ? S(1) : S(0));
  functor(p.data(), r.data());
  return r[k].v;
}

template <class S, int kCount>
void ExpectColumns(double tolerance) {
  using F = Waves<kCount>;
  ResidualBlocks<F, CpuBackend<S>> problem(kCount, {F()});
  typename CpuBackend<S>::Vector x(kCount), unit(kCount), column(F::kResiduals);
  for (int i = 0; i < kCount; ++i) x[i] = Parameter<S>(i);
  const auto linearization = LinearizeAt(problem, x);
  for (int c = 0; c < kCount; ++c) {
    CpuBackend<S>().Fill(0, unit);
    unit[c] = 1;
    linearization->ApplyJ(unit, column);
    for (int k = 0; k < F::kResiduals; ++k) {
      const S expected = Expected<F, S>(F(), k, c);
      EXPECT_NEAR(column[k], expected, tolerance * (1 + std::abs(expected))) << kCount << " parameters, column " << c;
    }
  }
}

TEST(DerivativePasses, ColumnsAreThoseOfOneDerivativeAtATime) {
  ExpectColumns<double, 1>(1e-14);
  ExpectColumns<double, 3>(1e-14);
  ExpectColumns<double, 26>(1e-14);
  ExpectColumns<double, 27>(1e-14);
  ExpectColumns<double, 300>(1e-14);
  ExpectColumns<float, 5>(1e-5);
  ExpectColumns<float, 111>(1e-5);
}

// A functor of four blocks, whose sizes are no multiples of the derivatives per evaluation.
struct FourBlocks {
  Calls* calls = nullptr;
  template <class T>
  bool operator()(const T* a, const T* b, const T* c, const T* d, T* r) const {
    std::vector<T> p(a, a + 13);
    p.insert(p.end(), b, b + 1);
    p.insert(p.end(), c, c + 20);
    p.insert(p.end(), d, d + 9);
    return Waves<43>{calls}(p.data(), r);
  }
};

struct FourBlocksEvaluation {
  static constexpr int kSizes[] = {13, 1, 20, 9};
  Calls calls;
  std::vector<double> p;
  std::vector<double> jacobian[4];
  double r[2] = {};
  bool defined = false;

  // Bit b of `wanted`: the Jacobian of block b is needed.
  explicit FourBlocksEvaluation(unsigned wanted, double first = 0.75) {
    const AutoDiffCost<FourBlocks, 2, 13, 1, 20, 9> cost(&calls);
    for (int i = 0; i < 43; ++i) p.push_back(Parameter<double>(i));
    p[0] = first;
    const double* parameters[4];
    double* jacobians[4];
    for (int b = 0, k = 0; b < 4; k += kSizes[b++]) {
      parameters[b] = p.data() + k;
      jacobian[b].assign(2 * static_cast<std::size_t>(kSizes[b]), -77);
      jacobians[b] = (wanted >> b & 1) != 0 ? jacobian[b].data() : nullptr;
    }
    defined = cost.Evaluate(parameters, r, jacobians);
  }
};

TEST(DerivativePasses, OnlyNeededBlocksAreDifferentiated) {
  for (unsigned wanted = 0; wanted < 16; ++wanted) {
    const FourBlocksEvaluation e(wanted);
    ASSERT_TRUE(e.defined);
    double plain[2];
    Waves<43>()(e.p.data(), plain);
    EXPECT_EQ(e.r[0], plain[0]);
    EXPECT_EQ(e.r[1], plain[1]);
    int columns = 0;
    for (int b = 0, k = 0; b < 4; k += e.kSizes[b++]) {
      const bool needed = (wanted >> b & 1) != 0;
      columns += needed ? e.kSizes[b] : 0;
      for (int row = 0; row < 2; ++row) {
        for (int i = 0; i < e.kSizes[b]; ++i) {
          Dual<double> p[43], r[2];
          for (int j = 0; j < 43; ++j) p[j] = Dual<double>(e.p[j], j == k + i ? 1.0 : 0.0);
          Waves<43>()(p, r);
          const double entry = e.jacobian[b][row * e.kSizes[b] + i];
          EXPECT_NEAR(entry, needed ? r[row].v : -77, 1e-13) << "blocks " << wanted << ", block " << b << ", " << i;
        }
      }
    }
    constexpr int kPerPass = DerivativesPerPass<double>(43);  // 22 for SSE2
    EXPECT_EQ(e.calls.derivatives, (columns + kPerPass - 1) / kPerPass) << wanted;
    EXPECT_EQ(e.calls.values, columns == 0 ? 1 : 0) << wanted;
  }
}

TEST(DerivativePasses, UndefinedResidualsEndTheEvaluation) {
  const FourBlocksEvaluation e(15, -1);
  EXPECT_FALSE(e.defined);
  EXPECT_EQ(e.calls.derivatives, 1);
}

TEST(DerivativePasses, FewParametersTakeOneEvaluation) {
  Calls calls;
  const AutoDiffCost<Waves<26>, 2, 26> cost(&calls);
  std::vector<double> p(26, 0.5), jacobian(52);
  const double* parameters[] = {p.data()};
  double r[2], *jacobians[] = {jacobian.data()};
  EXPECT_TRUE(cost.Evaluate(parameters, r, jacobians));
  EXPECT_EQ(calls.derivatives, 1);
  EXPECT_EQ(calls.values, 0);
}

// Leaves its second residual unset. All derivatives of that must be marked, in all evaluations.
struct Forgetful {
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0] * p[39];
  }
};

TEST(DerivativePasses, EntriesThatAreNotWrittenAreMarked) {
  const AutoDiffCost<Forgetful, 2, 40> cost;
  std::vector<double> p(40, 2.0), jacobian(80);
  const double* parameters[] = {p.data()};
  double r[2], *jacobians[] = {jacobian.data()};
  EXPECT_TRUE(cost.Evaluate(parameters, r, jacobians));
  EXPECT_EQ(r[0], 4);
  EXPECT_TRUE(IsUnwritten(r[1]));
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(jacobian[i], i == 0 || i == 39 ? 2 : 0);
    EXPECT_TRUE(IsUnwritten(jacobian[40 + i])) << i;
  }
}

// Not a template, so it gets one derivative at a time.
struct Overloads {
  void operator()(const double* p, double* r) const { r[0] = p[0] * p[1] * p[2]; }
  void operator()(const Dual<double>* p, Dual<double>* r) const { r[0] = p[0] * p[1] * p[2]; }
};

TEST(DerivativePasses, FunctorsOfDualNumbersOfOneDerivativeStillWork) {
  const AutoDiffCost<Overloads, 1, 3> cost;
  const double p[] = {2, 3, 5}, *parameters[] = {p};
  double r, jacobian[3], *jacobians[] = {jacobian};
  EXPECT_TRUE(cost.Evaluate(parameters, &r, jacobians));
  EXPECT_EQ(r, 30);
  EXPECT_EQ(jacobian[0], 15);
  EXPECT_EQ(jacobian[1], 10);
  EXPECT_EQ(jacobian[2], 6);
}

// Large arrays are on the heap.
static_assert(sizeof(ScratchArray<Dual<double, 25>, 300>) <= 64);

}  // namespace
}  // namespace vesta
