// SPDX-License-Identifier: Apache-2.0
// Automatic derivatives, priors and checks of derivatives. Adapted from Ceres 2.1's tests autodiff_test.cc,
// autodiff_cost_function_test.cc, dynamic_autodiff_cost_function_test.cc, normal_prior_test.cc and
// gradient_checker_test.cc in internal/ceres. docs/ceres_tests.md lists the omitted cases.
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "solver/check_problem.h"
#include "solver/cost_function.h"
#include "tests/solver/ceres/cost_derivatives.h"
#include "tests/solver/ceres/twin_problem.h"
#include "tests/support/random.h"

namespace vesta::test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The derivatives of the functor by dual numbers are those by jets, for every set of wanted blocks.
template <int kResiduals, int... kSizes, class F>
void ExpectJets(const F& functor, const Blocks& blocks) {
  const AutoDiffCost<F, kResiduals, kSizes...> ours(functor);
  const ceres::AutoDiffCostFunction<F, kResiduals, kSizes...> theirs(new F(functor));
  for (unsigned wanted = 0; wanted < 1U << sizeof...(kSizes); ++wanted) {
    ExpectNear(Evaluate(ours, blocks, wanted), Evaluate(theirs, blocks, wanted), 1e-13);
  }
}

Blocks RandomBlocks(const std::vector<int>& sizes, std::uint64_t seed) {
  Random random(seed);
  Blocks blocks;
  for (const int size : sizes) blocks.push_back(random.NormalVector<double>(static_cast<std::size_t>(size)));
  return blocks;
}

// The image of a homogeneous point X under a 3 x 4 camera matrix P.
struct Projective {
  template <class T>
  bool operator()(const T* P, const T* X, T* x) const {
    T image[3];
    for (int i = 0; i < 3; ++i) {
      image[i] = P[4 * i] * X[0];
      for (int k = 1; k < 4; ++k) image[i] += P[4 * i + k] * X[k];
    }
    x[0] = image[0] / image[2];
    x[1] = image[1] / image[2];
    return true;
  }
  template <class T>
  bool operator()(const T* PX, T* x) const {
    return (*this)(PX, PX + 12, x);
  }
};

// The image of X in a camera at c, whose orientation is the quaternion q (of any length).
struct Metric {
  template <class T>
  bool operator()(const T* q, const T* c, const T* X, T* x) const {
    const Eigen::Matrix<T, 3, 1> v(q[1], q[2], q[3]), d(X[0] - c[0], X[1] - c[1], X[2] - c[2]);
    const Eigen::Matrix<T, 3, 1> y = (q[0] * q[0] - v.dot(v)) * d + T(2.0) * (v.dot(d) * v + q[0] * v.cross(d));
    x[0] = y[0] / y[2];
    x[1] = y[1] / y[2];
    return true;
  }
};

TEST(CeresCasesAutoDiff, Cameras) {
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    const Blocks two = RandomBlocks({12, 4}, seed);
    ExpectJets<2, 12, 4>(Projective(), two);
    Blocks one = {two[0]};
    one[0].insert(one[0].end(), two[1].begin(), two[1].end());
    ExpectJets<2, 16>(Projective(), one);
    ExpectJets<2, 4, 3, 3>(Metric(), RandomBlocks({4, 3, 3}, seed));
  }
}

// Residual i is i x y^2. The number of residuals is a template argument.
template <int kResiduals>
struct Multiples {
  template <class T>
  bool operator()(const T* p, T* r) const {
    for (int i = 0; i < kResiduals; ++i) r[i] = T(i) * p[0] * p[1] * p[1];
    return true;
  }
};
template <int... kResiduals>
void ExpectMultiples(std::integer_sequence<int, kResiduals...>) {
  (ExpectJets<kResiduals + 1, 2>(Multiples<kResiduals + 1>(), {{1, 5.5}}), ...);
}

// The sum of any number of blocks of size 1. The last argument is the residual.
struct Sum {
  template <class... Arguments>
  bool operator()(Arguments*... arguments) const {
    auto* const r = std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...));
    using T = std::remove_pointer_t<std::remove_const_t<decltype(r)>>;
    const T* const all[] = {arguments...};
    r[0] = T(0.0);
    for (std::size_t i = 0; i + 1 < sizeof...(Arguments); ++i) r[0] += *all[i];
    return true;
  }
};
template <int... kOnes>
void ExpectSum() {
  Blocks blocks;
  for (std::size_t i = 0; i < sizeof...(kOnes); ++i) blocks.push_back({1.0 + static_cast<double>(i)});
  const Derivatives found = Evaluate(AutoDiffCost<Sum, 1, kOnes...>(), blocks);
  const double n = sizeof...(kOnes);
  EXPECT_EQ(found.residuals[0], n * (n + 1) / 2);
  for (const auto& jacobian : found.jacobians) EXPECT_EQ(jacobian, std::vector<double>{1});
}

TEST(CeresCasesAutoDiff, NumbersOfResidualsAndBlocks) {
  ExpectMultiples(std::make_integer_sequence<int, 9>());
  ExpectSum<1>();
  ExpectSum<1, 1>();
  ExpectSum<1, 1, 1>();
  ExpectSum<1, 1, 1, 1, 1, 1>();
  ExpectSum<1, 1, 1, 1, 1, 1, 1, 1, 1, 1>();
}

struct Bilinear {
  explicit Bilinear(double offset) : a(offset) {}
  double a;
  template <class T>
  bool operator()(const T* x, const T* y, T* r) const {
    r[0] = x[0] * y[0] + x[1] * y[1] - T(a);
    return true;
  }
};

TEST(CeresCasesAutoDiff, ForwardsItsArguments) {
  const Derivatives found = Evaluate(AutoDiffCost<Bilinear, 1, 2, 2>(1), {{1, 2}, {3, 4}});
  EXPECT_EQ(found.residuals, std::vector<double>{10});
  EXPECT_EQ(found.jacobians, (Blocks{{3, 4}, {1, 2}}));
}

struct FillsOne {
  template <class T>
  bool operator()(const T* x, T* r) const {
    r[0] = x[0];
    return true;
  }
};

// Ceres compares with a marker afterwards. vesta marks entries by a NaN.
TEST(CeresCasesAutoDiff, AnEntryThatIsNotWrittenIsNotFinite) {
  const std::shared_ptr<const CostFunction> costs[] = {std::make_shared<AutoDiffCost<FillsOne, 2, 1>>(),
                                                       std::make_shared<NumericDiffCost<FillsOne, 2, 1>>(FillsOne())};
  for (const auto& cost : costs) {
    BlockProblem problem;
    problem.AddParameterBlock(1);
    problem.AddResidualBlock(cost, nullptr, {0});
    const std::vector<double> x = {1};
    const auto linearization = problem.Linearize(View(x));
    EXPECT_FALSE(std::isfinite(problem.Cost(View(x))));
    EXPECT_EQ(linearization->residuals()[0], 1);
    EXPECT_FALSE(std::isfinite(linearization->residuals()[1]));
  }
}

// 21 residuals of blocks of 10 and 5: k - x_k and x_k - k, then sum (x_k^2 - 8 x_k) + sum y_k.
struct Dynamic21 {
  template <class T>
  bool operator()(const T* const* p, T* r) const {
    return (*this)(p[0], p[1], r);
  }
  template <class T>
  bool operator()(const T* x, const T* y, T* r) const {
    using std::pow;
    r[20] = T(0.0);
    for (int k = 0; k < 10; ++k) {
      r[2 * k] = T(k) - x[k];
      r[2 * k + 1] = x[k] - T(k);
      r[20] += pow(x[k], T(2.0)) - T(8.0) * x[k];
    }
    for (int k = 0; k < 5; ++k) r[20] += y[k];
    return true;
  }
};
// With X = x, Y = y_0 + 2 y_1, Z = z_0 + 3 z_1 + 6 z_2, the residuals X, Y, Z, XY, YZ, XZ, XYZ. The six numbers are in
// three blocks or in six.
struct Dynamic7 {
  template <class T>
  bool operator()(const T* const* p, T* r) const {
    return (*this)(p[0], p[1], p[2], r);
  }
  template <class T>
  bool operator()(const T* x, const T* y, const T* z, T* r) const {
    return (*this)(x, y, y + 1, z, z + 1, z + 2, r);
  }
  template <class T>
  bool operator()(const T* x, const T* y0, const T* y1, const T* z0, const T* z1, const T* z2, T* r) const {
    r[0] = *x;
    r[1] = *y0 + T(2.0) * *y1;
    r[2] = *z0 + T(3.0) * *z1 + T(6.0) * *z2;
    r[3] = r[0] * r[1];
    r[4] = r[1] * r[2];
    r[5] = r[0] * r[2];
    r[6] = r[3] * r[2];
    return true;
  }
};

template <class F>
std::unique_ptr<ceres::CostFunction> DynamicOf(int residuals, const std::vector<int>& sizes) {
  auto cost = std::make_unique<ceres::DynamicAutoDiffCostFunction<F, 3>>(new F);
  for (const int size : sizes) cost->AddParameterBlock(size);
  cost->SetNumResiduals(residuals);
  return cost;
}

// The sizes are known at compile time here, and at run time in Ceres. Any of the blocks may be constant.
TEST(CeresCasesAutoDiff, AgreesWithDynamicAutoDiff) {
  std::vector<double> even(10);
  for (std::size_t k = 0; k < 10; ++k) even[k] = 2.0 * static_cast<double>(k);
  const auto theirs21 = DynamicOf<Dynamic21>(21, {10, 5});
  for (const Blocks& at : {Blocks{std::vector<double>(10), std::vector<double>(5)}, Blocks{even, {0, 0, 0, 0, 0}}}) {
    for (unsigned wanted = 0; wanted < 4; ++wanted) {
      ExpectNear(Evaluate(AutoDiffCost<Dynamic21, 21, 10, 5>(), at, wanted), Evaluate(*theirs21, at, wanted), 0);
    }
  }
  const auto theirs7 = DynamicOf<Dynamic7>(7, {1, 2, 3});
  const Blocks three = {{0}, {1, 3}, {2, 4, 6}}, six = {{0}, {1}, {3}, {2}, {4}, {6}};
  for (unsigned wanted = 0; wanted < 8; ++wanted) {
    ExpectNear(Evaluate(AutoDiffCost<Dynamic7, 7, 1, 2, 3>(), three, wanted), Evaluate(*theirs7, three, wanted), 0);
  }
  ExpectJets<7, 1, 1, 1, 1, 1, 1>(Dynamic7(), six);
}

TEST(CeresCasesNormalPrior, OfEverySize) {
  for (int rows = 1; rows < 5; ++rows) {
    for (int cols = 1; cols < 5; ++cols) {
      const Blocks random = RandomBlocks({rows * cols, cols, cols}, static_cast<std::uint64_t>(rows));
      const NormalPrior ours(random[0], random[1]);
      const ceres::NormalPrior theirs(Eigen::Map<const RowMajor>(random[0].data(), rows, cols),
                                      Eigen::VectorXd::Map(random[1].data(), cols));
      for (const unsigned wanted : {0U, 1U}) {
        ExpectNear(Evaluate(ours, {random[2]}, wanted), Evaluate(theirs, {random[2]}, wanted), 1e-14);
      }
    }
  }
}

bool Passes(BlockProblem& problem, const std::vector<double>& x) {
  CpuBackend<double> backend;
  const ProblemCheck check = CheckProblem<CpuBackend<double>>(backend, problem, View(x));
  EXPECT_EQ(check.ok(), check.faults.empty());
  return check.ok();
}

// The residual exp(-a^T x) of three blocks, with an error in the derivatives.
TEST(CeresCasesGradientChecker, FindsAWrongDerivative) {
  const Blocks a = RandomBlocks({2, 3, 4}, 5), x = RandomBlocks({2, 3, 4}, 6);
  for (const double error : {0.0, 1e-3}) {
    TwinProblem twin;
    for (const auto& block : x) twin.AddBlock(block);
    twin.Add(1,
             [&](const double* const* p, double* r, double** j) {
               double dot = 0;
               for (std::size_t b = 0; b < 3; ++b) {
                 for (std::size_t i = 0; i < a[b].size(); ++i) dot += a[b][i] * p[b][i];
               }
               r[0] = std::exp(-dot);
               for (std::size_t b = 0; j != nullptr && b < 3; ++b) {
                 for (std::size_t i = 0; j[b] != nullptr && i < a[b].size(); ++i) j[b][i] = -r[0] * a[b][i] + error;
               }
               return true;
             },
             {0, 1, 2});
    EXPECT_EQ(Passes(twin.ours(), twin.x()), error == 0);
  }
}

// x (+) d = x + A d.
class Affine final : public Manifold {
 public:
  explicit Affine(Eigen::Matrix<double, 3, 2, Eigen::RowMajor> a) : a_(std::move(a)) {}
  int ambient_size() const override { return 3; }
  int tangent_size() const override { return 2; }
  void Plus(const double* x, const double* delta, double* out) const override {
    Eigen::Vector3d::Map(out) = Eigen::Vector3d::Map(x) + a_ * Eigen::Vector2d::Map(delta);
  }
  void PlusJacobian(const double*, double* j) const override { RowMajor::Map(j, 3, 2) = a_; }

 private:
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> a_;
};

// A linear residual with a wrong derivative for one entry of a block. The error has no effect if steps on the block's
// manifold never change that entry. A solve that checks derivatives ends accordingly.
TEST(CeresCasesGradientChecker, UsesTheManifold) {
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> j0;
  j0 << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> j1, moving, resting;
  j1 << 10, 11, 12, 13, 14, 15;
  moving << 1.5, 2.5, 3.5, 4.5, 5.5, 6.5;
  resting = moving;
  resting.row(2).setZero();
  for (const auto& [error, plus, correct] :
       {std::tuple(0.0, moving, true), std::tuple(0.001, moving, false), std::tuple(0.001, resting, true)}) {
    BlockProblem problem;
    problem.AddParameterBlock(3, std::make_shared<Affine>(plus));
    problem.AddParameterBlock(2);
    const Evaluation evaluate = [&, wrong = error](const double* const* p, double* r, double** j) {
      Eigen::Vector3d::Map(r) =
          Eigen::Vector3d(100, 200, 300) + j0 * Eigen::Vector3d::Map(p[0]) + j1 * Eigen::Vector2d::Map(p[1]);
      if (j != nullptr && j[0] != nullptr) {
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> out(j[0]);
        out = j0;
        out.col(2).array() += wrong;
      }
      if (j != nullptr && j[1] != nullptr) RowMajor::Map(j[1], 3, 2) = j1;
      return true;
    };
    problem.AddResidualBlock(std::make_shared<OurFunction>(3, std::vector<int>{3, 2}, evaluate), nullptr, {0, 1});
    std::vector<double> x = {1, 2, 3, 4, 5};
    EXPECT_EQ(Passes(problem, x), correct) << error;
    LmOptions options;
    options.check_derivatives = true;
    options.step_control.initial_lambda = 1e-10;
    const LmSummary summary = SolveLm(problem, x, options);
    EXPECT_EQ(summary.status == LmStatus::kCheckFailed, !correct) << summary.FullReport();
    if (correct) {
      EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
      EXPECT_LE(summary.final_cost, 1e-12);
    }
  }
}

}  // namespace
}  // namespace vesta::test
