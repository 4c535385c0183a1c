// SPDX-License-Identifier: Apache-2.0
// The Ceres bridge agrees with ceres::Problem::Evaluate and ceres::Solve.
#include "solver/ceres/ceres_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "kernels/core/check.h"
#include "solver/bounds.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/linearize_at.h"

namespace vesta {
namespace {

using ceres_bridge::CeresProblem;

// Two poses (quaternion x y z w, position) and the measured pose of one relative to the other.
struct Between {
  Eigen::Vector3d seen;
  template <class T>
  bool operator()(const T* qa, const T* ta, const T* qb, const T* tb, T* r) const {
    const Eigen::Map<const Eigen::Quaternion<T>> a(qa), b(qb);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> pa(ta), pb(tb);
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(r);
    out.template head<3>() = a.conjugate() * (pb - pa) - seen.cast<T>();
    out.template tail<3>() = (a.conjugate() * b).vec();
    return true;
  }
};

// A unit direction attracted to a point, plus entries of an offset.
struct Drawn {
  Eigen::Vector3d to;
  template <class T>
  bool operator()(const T* n, const T* o, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = n[i] + o[i % 2] - to[i];
    return true;
  }
};

// Ceres 2.1 has the deprecated LocalParameterization too.
#if CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR < 2
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
void SetDeprecatedQuaternion(ceres::Problem& problem, double* q) {
  problem.SetParameterization(q, new ceres::EigenQuaternionParameterization);
}
void SetDeprecatedSubset(ceres::Problem& problem, double* t) {
  problem.SetParameterization(t, new ceres::SubsetParameterization(3, {1}));
}
#pragma GCC diagnostic pop
#else
void SetDeprecatedQuaternion(ceres::Problem& problem, double* q) {
  problem.SetManifold(q, new ceres::EigenQuaternionManifold);
}
void SetDeprecatedSubset(ceres::Problem& problem, double* t) {
  problem.SetManifold(t, new ceres::SubsetManifold(3, {1}));
}
#endif

// A problem with every feature that the bridge supports.
struct Mixture {
  Mixture() {
    srand(21);
    for (auto& pose : poses) {
      Eigen::Map<Eigen::Vector4d>(pose.q).setRandom().normalize();
      Eigen::Map<Eigen::Vector3d>(pose.t).setRandom();
      problem.AddParameterBlock(pose.q, 4);
      problem.AddParameterBlock(pose.t, 3);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      if (i % 2 == 0) {
        problem.SetManifold(poses[i].q, new ceres::EigenQuaternionManifold);
      } else {
        SetDeprecatedQuaternion(problem, poses[i].q);
      }
    }
    Eigen::Map<Eigen::Vector3d>(direction).setRandom().normalize();
    problem.AddParameterBlock(direction, 3, new ceres::SphereManifold<3>);
    problem.AddParameterBlock(offset, 2);
    problem.SetParameterLowerBound(offset, 0, -0.01);
    problem.SetParameterUpperBound(offset, 0, 0.01);
    SetDeprecatedSubset(problem, poses[3].t);
    problem.SetParameterBlockConstant(poses[0].q);
    problem.SetParameterBlockConstant(poses[0].t);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        ceres::LossFunction* loss = nullptr;
        if (i == 3) loss = new ceres::HuberLoss(0.3);
        if (i == 2) loss = new ceres::CauchyLoss(0.2);
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Between, 6, 4, 3, 4, 3>(new Between{Eigen::Vector3d::Random()}), loss,
            poses[i].q, poses[i].t, poses[k].q, poses[k].t);
      }
    }
    for (int i = 0; i < 3; ++i) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Drawn, 3, 3, 2>(new Drawn{Eigen::Vector3d::Random()}),
                               i == 0 ? new ceres::ScaledLoss(nullptr, 0.5, ceres::TAKE_OWNERSHIP) : nullptr, direction,
                               offset);
    }
  }
  struct Pose {
    double q[4], t[3];
    bool operator==(const Pose&) const = default;
  } poses[4];
  double direction[3], offset[2] = {0, 0};
  ceres::Problem problem;
};

TEST(CeresProblemTest, EvaluatesAsCeresDoes) {
  Mixture mixture;
  CeresProblem bridge(mixture.problem);
  const auto x = bridge.Gather();
  double cost = 0;
  std::vector<double> residuals, gradient;
  ceres::CRSMatrix jacobian;
  std::vector<double*> blocks;
  mixture.problem.GetParameterBlocks(&blocks);
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks;
  ASSERT_TRUE(mixture.problem.Evaluate(options, &cost, &residuals, &gradient, &jacobian));
  EXPECT_NEAR(bridge.problem().Cost(x), cost, 1e-14 * cost);
  const auto linearization = LinearizeAt(bridge.problem(), x);
  ASSERT_EQ(linearization->num_residuals(), static_cast<Index>(residuals.size()));
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    EXPECT_NEAR(linearization->residuals()[static_cast<Index>(i)], residuals[i], 1e-14);
  }
  // Column by column: Ceres orders them as in `blocks`; constant blocks are zero columns.
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(jacobian.num_rows, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int k = jacobian.rows[static_cast<std::size_t>(row)]; k < jacobian.rows[static_cast<std::size_t>(row) + 1];
         ++k) {
      dense(row, jacobian.cols[static_cast<std::size_t>(k)]) = jacobian.values[static_cast<std::size_t>(k)];
    }
  }
  Cpu::Vector unit(bridge.problem().num_tangent()), column(linearization->num_residuals()), g(unit.size());
  linearization->Gradient(g);
  int theirs = 0;
  Index seen = 0;
  for (const double* block : blocks) {
    const int b = bridge.block(block), size = bridge.problem().tangent_size(b);
    const Index first = bridge.problem().tangent_offset(b);
    for (int c = 0; c < size; ++c, ++seen) {
      unit[first + c] = 1;
      linearization->ApplyJ(unit, column);
      unit[first + c] = 0;
      EXPECT_LE((AsEigen(column.view()) - dense.col(theirs + c)).norm(), 1e-13);
      EXPECT_NEAR(g[first + c], gradient[static_cast<std::size_t>(theirs + c)], 1e-13);
    }
    theirs += mixture.problem.ParameterBlockTangentSize(block);
  }
  EXPECT_EQ(seen, bridge.problem().num_tangent());
}

TEST(CeresProblemTest, ReachesCeressMinimum) {
  Mixture ours, theirs;
  ceres::Solver::Options options;
  options.max_num_iterations = 500;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-15;
  options.linear_solver_type = ceres::DENSE_QR;
  ceres::Solver::Summary expected;
  ceres::Solve(options, &theirs.problem, &expected);
  ceres::Solver::Options cholesky = options;
  cholesky.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  Mixture by_factor;
  const LmSummary exact = ceres_bridge::Solve(ceres_bridge::FromCeres(cholesky), by_factor.problem);
  EXPECT_LE(exact.final_cost, expected.final_cost * (1 + 1e-8)) << exact.FullReport();
  EXPECT_NE(exact.linear_solver.find("sparse Cholesky"), std::string::npos);
  for (const auto kind : {LinearSolverKind::kDenseQr, LinearSolverKind::kPcg, LinearSolverKind::kLsmr}) {
    Mixture fresh;
    LmOptions lm = ceres_bridge::FromCeres(options);
    lm.normal_system.linear_solver = kind;
    lm.normal_system.pcg = {.max_iterations = 500, .relative_tolerance = 1e-12, .model_tolerance = 0};
    const LmSummary summary = ceres_bridge::Solve(lm, fresh.problem);
    EXPECT_NEAR(summary.initial_cost, expected.initial_cost, 1e-13 * expected.initial_cost);
    EXPECT_LE(summary.final_cost, expected.final_cost * (1 + 1e-8) + 1e-14 * expected.initial_cost)
        << ToString(kind) << summary.FullReport();
    double cost = 0;
    ASSERT_TRUE(fresh.problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
    EXPECT_NEAR(cost, summary.final_cost, 1e-13 * cost) << "the solution is in the parameter blocks";
    EXPECT_GE(fresh.offset[0], -0.01);
    EXPECT_LE(fresh.offset[0], 0.01);
    EXPECT_EQ(fresh.poses[0], ours.poses[0]) << "constant blocks do not move";
    EXPECT_EQ(fresh.poses[3].t[1], ours.poses[3].t[1]);
  }
}

TEST(CeresProblemTest, OptionsCarryOver) {
  ceres::Solver::Options from;
  from.max_num_iterations = 7;
  from.initial_trust_region_radius = 100;
  from.eta = 0.01;
  from.linear_solver_type = ceres::CGNR;
  from.preconditioner_type = ceres::JACOBI;
  const LmOptions options = ceres_bridge::FromCeres(from);
  options.Validate();
  EXPECT_EQ(options.max_iterations, 7);
  EXPECT_EQ(options.step_control.initial_lambda, 0.01);
  EXPECT_EQ(options.normal_system.pcg.model_tolerance, 0.01);
  EXPECT_EQ(options.normal_system.linear_solver, LinearSolverKind::kPcg);
  EXPECT_EQ(options.normal_system.preconditioner, PreconditionerKind::kBlockJacobi);
  from.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  const NormalSystemOptions exact = ceres_bridge::FromCeres(from).normal_system;
  EXPECT_EQ(exact.linear_solver, LinearSolverKind::kPcg);
  EXPECT_EQ(exact.preconditioner, PreconditionerKind::kSparseCholesky);
  EXPECT_LE(exact.pcg.relative_tolerance, 1e-10);
  double nowhere = 0;
  ceres::Problem empty;
  EXPECT_THROW(CeresProblem(empty).block(&nowhere), Error);
  EXPECT_TRUE(IsConverged(ceres_bridge::Solve(options, empty).status));
}

// A cost function that leaves an entry unwritten is named in the message, as without the bridge.
class Incomplete final : public ceres::SizedCostFunction<2, 1> {
 public:
  Incomplete(bool value, bool derivative) : value_(value), derivative_(derivative) {}
  bool Evaluate(double const* const* p, double* r, double** j) const override {
    r[0] = p[0][0];
    if (value_) r[1] = p[0][0] - 2;
    if (j && j[0]) {
      j[0][0] = 1;
      if (derivative_) j[0][1] = 1;
    }
    return true;
  }

 private:
  bool value_, derivative_;
};

TEST(CeresProblem, EntriesThatNobodyWritesAreNamed) {
  for (const bool value : {true, false}) {
    double x = 5;
    ceres::Problem problem;
    problem.AddResidualBlock(new Incomplete(true, true), nullptr, &x);
    problem.AddResidualBlock(new Incomplete(value, !value), nullptr, &x);
    const LmSummary summary = ceres_bridge::Solve(LmOptions(), problem);
    EXPECT_EQ(summary.status, LmStatus::kNonFinite) << summary.message;
    EXPECT_NE(
        summary.message.find(value ? "the derivative of residual 1 of residual block 1 by entry 0 of parameter "
                                     "block 0 was not written, at parameter block 0 = [5]"
                                   : "residual 1 of residual block 1 was not written, at parameter block 0 = [5]"),
        std::string::npos)
        << summary.message;
    EXPECT_EQ(x, 5);
  }
}

}  // namespace
}  // namespace vesta
