// SPDX-License-Identifier: Apache-2.0
// Cost functions whose sizes are set at run time, and functors that call cost functions.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "solver/cost_function_to_functor.h"
#include "solver/dynamic_autodiff_cost.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

// r_k = sin((k + 1) p[0]) + the sum of p[i] q[i % 2], for 11 numbers p and 2 numbers q.
template <class T>
void WavesOfTwo(const T* p, const T* q, int rows, T* r) {
  using std::sin;
  for (int k = 0; k < rows; ++k) {
    r[k] = sin(T(k + 1.0) * p[0]);
    for (int i = 0; i < 11; ++i) r[k] += p[i] * q[i % 2];
  }
}
struct FixedWaves {
  template <class T>
  bool operator()(const T* p, const T* q, T* r) const {
    WavesOfTwo(p, q, 3, r);
    return p[0] < T(5.0);
  }
};
struct DynamicWaves {
  int rows;
  template <class T>
  bool operator()(const T* const* blocks, T* r) const {
    WavesOfTwo(blocks[0], blocks[1], rows, r);
    return blocks[0][0] < T(5.0);
  }
};

// Residuals and Jacobians at fixed parameters. wanted: the blocks with Jacobians.
struct Values {
  explicit Values(const CostFunction& cost, std::vector<bool> wanted = {true, true}, double first = 0.3) {
    std::vector<double> p(11), q = {0.7, -1.2};
    for (std::size_t i = 0; i < 11; ++i) p[i] = 0.1 * static_cast<double>(i) + first;
    const double* const parameters[] = {p.data(), q.data()};
    double* jacobians[] = {wanted[0] ? by_p.data() : nullptr, wanted[1] ? by_q.data() : nullptr};
    ok = cost.Evaluate(parameters, r.data(), jacobians);
    std::vector<double> alone(3);
    EXPECT_EQ(cost.Evaluate(parameters, alone.data(), nullptr), ok);
    EXPECT_TRUE(!ok || alone == r);
  }
  bool operator==(const Values&) const = default;
  bool ok = false;
  std::vector<double> r = std::vector<double>(3), by_p = std::vector<double>(33), by_q = std::vector<double>(6);
};

TEST(DynamicAutoDiffCost, EqualsAutoDiffCost) {
  const AutoDiffCost<FixedWaves, 3, 11, 2> fixed;
  const DynamicAutoDiffCost<DynamicWaves> dynamic({3}, 3, {11, 2});
  const DynamicAutoDiffCost<DynamicWaves, 1> one_by_one({3}, 3, {11, 2});
  const DynamicAutoDiffCost<DynamicWaves, 32> at_once({3}, 3, {11, 2});
  for (const std::vector<bool>& wanted :
       {std::vector<bool>{true, true}, {true, false}, {false, true}, {false, false}}) {
    const Values expected(fixed, wanted);
    EXPECT_TRUE(expected.ok);
    EXPECT_EQ(Values(dynamic, wanted), expected);
    EXPECT_EQ(Values(one_by_one, wanted), expected);
    EXPECT_EQ(Values(at_once, wanted), expected);
  }
  EXPECT_FALSE(Values(dynamic, {true, true}, 6).ok);
}

// 2 waves - 1, by a cost function that the functor calls.
struct Doubled {
  CostFunctionToFunctor waves;
  template <class T>
  bool operator()(const T* p, const T* q, T* r) const {
    T moved[2] = {q[1] * q[0], q[0]};
    if (!waves(p, moved, r)) return false;
    for (int k = 0; k < 3; ++k) r[k] = T(2.0) * r[k] - T(1.0);
    return true;
  }
};
struct DoubledByHand {
  template <class T>
  bool operator()(const T* p, const T* q, T* r) const {
    T moved[2] = {q[1] * q[0], q[0]};
    if (!FixedWaves()(p, static_cast<const T*>(moved), r)) return false;
    for (int k = 0; k < 3; ++k) r[k] = T(2.0) * r[k] - T(1.0);
    return true;
  }
};
struct DoubledDynamic {
  CostFunctionToFunctor waves;
  template <class T>
  bool operator()(const T* const* blocks, T* r) const {
    const T moved[2] = {blocks[1][1] * blocks[1][0], blocks[1][0]};
    const T* const both[] = {blocks[0], moved};
    if (!waves(both, r)) return false;
    for (int k = 0; k < 3; ++k) r[k] = T(2.0) * r[k] - T(1.0);
    return true;
  }
};

TEST(CostFunctionToFunctor, FollowsTheChainRule) {
  const CostFunctionToFunctor waves(std::make_shared<AutoDiffCost<FixedWaves, 3, 11, 2>>());
  const Values expected(AutoDiffCost<DoubledByHand, 3, 11, 2>{});
  const AutoDiffCost<Doubled, 3, 11, 2> fixed(Doubled{waves});
  const DynamicAutoDiffCost<DoubledDynamic> dynamic({waves}, 3, {11, 2});
  for (const CostFunction* cost :
       {static_cast<const CostFunction*>(&fixed), static_cast<const CostFunction*>(&dynamic)}) {
    const Values found(*cost);
    EXPECT_TRUE(found.ok);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found.r[k], expected.r[k], 1e-15);
    for (std::size_t k = 0; k < 33; ++k) EXPECT_NEAR(found.by_p[k], expected.by_p[k], 1e-14);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(found.by_q[k], expected.by_q[k], 1e-14);
    EXPECT_FALSE(Values(*cost, {true, true}, 6).ok);
  }
  double r[3];
  EXPECT_THAT([&] { waves(static_cast<const double*>(r), r); }, ThrowsError(kBadArgument));
  EXPECT_THAT([] { CostFunctionToFunctor(nullptr); }, ThrowsError(kBadArgument));
}

}  // namespace
}  // namespace vesta
