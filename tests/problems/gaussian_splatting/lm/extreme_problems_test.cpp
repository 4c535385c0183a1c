// SPDX-License-Identifier: Apache-2.0
// Extreme images, cameras and steps. The operators stay finite and consistent with one quadratic model. A solve ends in
// a valid status with a finite model that is not worse than the start.
#include <limits>

#include "tests/problems/gaussian_splatting/host_vectors.h"
#include "tests/problems/gaussian_splatting/lm/extreme_problem.h"

namespace vesta::gs::test {
namespace {

constexpr Index kCount = kExtremeCount;

constexpr std::initializer_list<JacobianKind> kKinds = {JacobianKind::kOnTheFly, JacobianKind::kCache32,
                                                        JacobianKind::kCache16};

class ExtremeProblems : public testing::TestWithParam<ExtremeProblem> {};
INSTANTIATE_TEST_SUITE_P(Of, ExtremeProblems, testing::ValuesIn(kExtremeProblems),
                         [](const auto& param) { return std::string(param.param.name); });

TEST_P(ExtremeProblems, OperatorsInDouble) { CheckOperators<CpuBackend<double>>(GetParam()); }
TEST_P(ExtremeProblems, OperatorsInFloat) { CheckOperators<CpuBackend<float>>(GetParam()); }
TEST_P(ExtremeProblems, SolvesInDouble) { CheckSolves<CpuBackend<double>>(GetParam(), kKinds); }
TEST_P(ExtremeProblems, SolvesInFloat) { CheckSolves<CpuBackend<float>>(GetParam(), kKinds); }

template <class S>
class ExtremeSteps : public testing::Test {
 protected:
  RingProblem<S> ring_ = ProblemOf<S>(kExtremeProblems[0]);
  static LmSummary Solve(RingProblem<S>& ring, const LmStageOptions& lm) {
    return SolveAndCheck<CpuBackend<S>>(ring, lm);
  }
  S& At(int attribute, Index gaussian) { return ring_.x[attribute * kCount + gaussian]; }
};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(ExtremeSteps, Scalars);

// Half of the Gaussians have an extreme value. A solve may move them, but not increase the cost.
TYPED_TEST(ExtremeSteps, StartsWithGaussiansAtTheirLimits) {
  struct Limit {
    const char* name;
    int first, last;  // attributes
    double value;
  };
  constexpr Limit kLimits[] = {{"1e6 across", splat::kLogScale, splat::kLogScale + 2, 13.8},
                               {"1e-6 across", splat::kLogScale, splat::kLogScale + 2, -13.8},
                               {"needles", splat::kLogScale, splat::kLogScale, 7},
                               {"logits of 50", splat::kOpacity, splat::kOpacity, 50},
                               {"logits of -50", splat::kOpacity, splat::kOpacity, -50},
                               {"quaternions of zero", splat::kQuaternion, splat::kQuaternion + 3, 0},
                               {"harmonics of 1e4", splat::kSh, splat::kSh + 11, 1e4},
                               {"harmonics of -1e4", splat::kSh, splat::kSh + 11, -1e4},
                               {"one position", splat::kMean, splat::kMean + 2, 0.1}};
  for (const Limit& limit : kLimits) {
    SCOPED_TRACE(limit.name);
    this->ring_ = ProblemOf<TypeParam>(kExtremeProblems[0]);
    for (int attribute = limit.first; attribute <= limit.last; ++attribute) {
      for (Index i = 0; i < kCount; i += 2) this->At(attribute, i) = static_cast<TypeParam>(limit.value);
    }
    const LmSummary summary = this->Solve(this->ring_, FewIterations());
    EXPECT_GT(summary.num_accepted, 0) << summary.FullReport();
  }
}

TYPED_TEST(ExtremeSteps, DampingAtItsLowerBound) {
  for (const LmDamping damping : {LmDamping::kLearningRates, LmDamping::kDiagonal}) {
    LmStageOptions lm = FewIterations();
    lm.initial_lambda = lm.min_lambda = 1e-30;
    lm.pcg_iterations = 30;
    this->ring_.options.damping = damping;
    this->Solve(this->ring_, lm);
  }
}

TYPED_TEST(ExtremeSteps, DampingAtItsUpperBound) {
  LmStageOptions lm = FewIterations();
  lm.initial_lambda = lm.max_lambda = 1e30;
  this->Solve(this->ring_, lm);
}

// Gaussians behind all cameras, transparent ones and non-finite ones have zero columns and stay bit-identical.
TYPED_TEST(ExtremeSteps, GaussiansThatNobodySeesStay) {
  using S = TypeParam;
  for (const LmDamping damping : {LmDamping::kLearningRates, LmDamping::kDiagonal}) {
    SCOPED_TRACE(static_cast<int>(damping));
    RingProblem<S>& ring = this->ring_;
    ring = ProblemOf<S>(kExtremeProblems[0]);
    ring.options.damping = damping;
    this->At(splat::kMean, 3) = 1e4;
    this->At(splat::kOpacity, 7) = -50;
    HostBuffer<S> before;
    before.CopyFrom(ring.x);
    const LmSummary summary = this->Solve(ring, FewIterations());
    EXPECT_GT(summary.num_accepted, 0);
    for (const Index gaussian : {3, 7}) {
      for (Index k = gaussian; k < before.size(); k += kCount) ASSERT_EQ(ring.x[k], before[k]) << k;
    }
  }
}

TYPED_TEST(ExtremeSteps, NobodySeesAnything) {
  using S = TypeParam;
  for (Index i = 0; i < kCount; ++i) this->At(splat::kOpacity, i) = -50;
  HostBuffer<S> before;
  before.CopyFrom(this->ring_.x);
  this->Solve(this->ring_, FewIterations());
  EXPECT_EQ(ToVector(this->ring_.x), ToVector(before));
}

// A NaN or infinite pixel ends the solve before the first iteration, with x unchanged.
TYPED_TEST(ExtremeSteps, PixelsThatAreNotFiniteAreRefused) {
  using S = TypeParam;
  HostBuffer<S> before;
  before.CopyFrom(this->ring_.x);
  for (const S bad : {std::numeric_limits<S>::quiet_NaN(), std::numeric_limits<S>::infinity()}) {
    this->ring_.truth[1][17] = bad;
    EXPECT_EQ(this->Solve(this->ring_, FewIterations()).status, LmStatus::kNonFinite);
    EXPECT_EQ(ToVector(this->ring_.x), ToVector(before));
  }
}

// The cost is never NaN, even if exp of the scales, the squares of quaternions or sums overflow. At worst it is the
// cost without the non-finite Gaussians.
TYPED_TEST(ExtremeSteps, StepsThatOverflowHaveACost) {
  using S = TypeParam;
  SplatProblem<CpuBackend<S>> problem = this->ring_.Make();
  HostBuffer<S> direction(this->ring_.x.size());
  CpuBackend<S> backend;
  FillRandom(backend, 220, direction.view());
  for (double length = 1e-3; length < 1e37; length *= 10) {
    HostBuffer<S> x;
    x.CopyFrom(this->ring_.x);
    backend.Axpby(length, direction, 1, x);
    EXPECT_TRUE(std::isfinite(problem.Cost(x))) << length;
  }
}

// Nearly undamped steps are far too long: during the line search, splats change tiles and cross the alpha floor.
TYPED_TEST(ExtremeSteps, LineSearchOverDecisionsDescends) {
  LmStageOptions lm = FewIterations();
  lm.initial_lambda = lm.min_lambda = 1e-12;
  lm.pcg_iterations = 30;
  lm.line_search = true, lm.line_search_views = 1;
  const LmSummary summary = this->Solve(this->ring_, lm);
  EXPECT_GT(summary.num_accepted, 0) << summary.FullReport();
}

}  // namespace
}  // namespace vesta::gs::test
