// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/pose_graph_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <numbers>
#include <numeric>

#include "solver/check_problem.h"
#include "solver/compose.h"
#include "solver/internal/derivative_check.inl"
#include "solver/levenberg_marquardt.h"
#include "tests/problems/pose_graph/ring_graph.h"
#include "tests/support/linearize_at.h"
#include "tests/support/test_files.h"

namespace vesta::pose_graph {
namespace {

using B = CpuBackend<double>;

template <class Space>
class PoseGraphDerivatives : public testing::Test {
 protected:
  void Check(const PoseGraphProblemOptions& options, std::vector<Index> fixed) {
    PoseGraph graph = test::RingGraph<Space>(14, 0.2, 1);
    graph.fixed = std::move(fixed);
    CheckGraph(options, graph);
  }
  void CheckGraph(const PoseGraphProblemOptions& options, const PoseGraph& graph) {
    PoseGraphProblem problem(graph, options);
    const Index held = std::max<Index>(1, static_cast<Index>(graph.fixed.size()));
    EXPECT_EQ(problem.num_tangent(), (graph.num_poses() - held) * Space::kTangent);
    B backend;
    const B::Vector x = test::Start(problem);
    const auto linearization = LinearizeAt(problem, x);
    JacobianMap<B> jacobian(linearization->get());
    EXPECT_LE(WorstAdjointError(backend, jacobian, 2), 1e-12);
    EXPECT_LE(DiagonalError(backend, linearization->get()), 1e-10);
    EXPECT_LE(BlockError(backend, linearization->get()), 1e-10);
    // H v is J^T J v.
    B::Vector v(problem.num_tangent()), Hv(v.size()), u(linearization->num_residuals()), expected(v.size());
    FillRandom(backend, 3, v.view());
    linearization->ApplyH(v, Hv);
    linearization->ApplyJ(v, u);
    linearization->ApplyJT(u, expected);
    const double scale = backend.MaxAbs(expected);
    for (Index k = 0; k < v.size(); ++k) EXPECT_NEAR(Hv[k], expected[k], 1e-10 * scale);
    EXPECT_LE(GradientError(backend, problem, x, v, 1e-5), 1e-7);
    // If there is a loss, the corrected Jacobian is not the derivative of the corrected residuals.
    if (!options.loss) {
      EXPECT_LE(TangentError(backend, problem, x, 0, v, 1e-5), 1e-7);
    }
  }
};
using Spaces = testing::Types<Se2, Se3>;
TYPED_TEST_SUITE(PoseGraphDerivatives, Spaces);

TYPED_TEST(PoseGraphDerivatives, Plain) { this->Check({}, {}); }
TYPED_TEST(PoseGraphDerivatives, ErrorOfCeres) { this->Check({.error = EdgeError::kCeres}, {}); }
TYPED_TEST(PoseGraphDerivatives, IsotropicError) { this->Check({.error = EdgeError::kIsotropic}, {}); }
TYPED_TEST(PoseGraphDerivatives, RobustLoss) { this->Check({.loss = std::make_shared<HuberLoss>(0.5)}, {}); }
TYPED_TEST(PoseGraphDerivatives, FixedPoses) { this->Check({}, {2, 3, 13}); }
TYPED_TEST(PoseGraphDerivatives, LandmarksAndPriors) {
  for (const EdgeError error : {EdgeError::kG2o, EdgeError::kCeres, EdgeError::kIsotropic}) {
    PoseGraph graph = test::RingGraph<TypeParam>(14, 0.2, 1);
    test::AddLandmarksAndPriors<TypeParam>(graph, 5);
    this->CheckGraph({.error = error}, graph);
  }
}

template <class Space>
Eigen::Isometry3d AsIsometry(const double* pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  if constexpr (Space::kPose == 3) {
    isometry.linear() = Eigen::AngleAxisd(pose[2], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    isometry.translation() << pose[0], pose[1], 0;
  } else {
    isometry.linear() = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix();
    isometry.translation() << pose[0], pose[1], pose[2];
  }
  return isometry;
}

// 1/2 e^T Lambda e with the pose e = m^-1 (a^-1 b) of each edge, as g2o computes it.
template <class Space>
std::vector<double> CostsOfG2o(const PoseGraph& graph) {
  constexpr int D = Space::kTangent;
  std::vector<double> costs;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const auto pose = [&](Index i) { return AsIsometry<Space>(graph.poses.data() + i * Space::kPose); };
    const Eigen::Isometry3d measured = AsIsometry<Space>(graph.measurements.data() + k * Space::kPose);
    const Eigen::Isometry3d difference =
        measured.inverse() * (pose(graph.edges[k].from).inverse() * pose(graph.edges[k].to));
    Eigen::Matrix<double, D, 1> e;
    if constexpr (D == 3) {
      e << difference.translation().head<2>(), std::atan2(difference(1, 0), difference(0, 0));
    } else {
      const Eigen::Quaterniond q(difference.linear());
      e << difference.translation(), (q.w() < 0 ? -1 : 1) * q.vec();
    }
    const double* upper = graph.information.data() + k * static_cast<std::size_t>(D * (D + 1) / 2);
    double cost = 0;
    for (int i = 0; i < D; ++i) {
      for (int j = i; j < D; ++j, ++upper) cost += (i == j ? 0.5 : 1) * *upper * e[i] * e[j];
    }
    costs.push_back(cost);
  }
  return costs;
}

TYPED_TEST(PoseGraphDerivatives, CostIsThatOfG2o) {
  PoseGraph graph = test::RingGraph<TypeParam>(9, 0.3, 2);
  if constexpr (TypeParam::kPose == 7) {  // the same rotation
    for (std::size_t k = 3; k < 7; ++k) graph.measurements[7 + k] *= -1;
  }
  PoseGraphProblem problem(graph);
  const std::vector<double> costs = CostsOfG2o<TypeParam>(graph);
  const double sum = std::accumulate(costs.begin(), costs.end(), 0.0);
  const B::Vector x = test::Start(problem);
  EXPECT_NEAR(problem.Cost(x), sum, 1e-12 * sum);
  EXPECT_EQ(problem.num_units(), graph.num_edges());
  const Index units[] = {1, 4};
  EXPECT_NEAR(problem.Cost(x, units), costs[1] + costs[4], 1e-12 * sum);
}

// With anisotropic information, the minimum depends on the frame of the position error.
TEST(PoseGraphProblem, MinimumIsThatOfG2o) {
  const double right = std::numbers::pi / 2;
  const PoseGraph graph{.space = PoseSpace::kSe2,
                        .ids = {0, 1, 2},
                        .poses = {0, 0, 0, 1.2, 0.2, 1.5, 0, 0, 0},
                        .fixed = {0, 2},
                        .edges = {{0, 1}, {2, 1}},
                        .measurements = {1, 0, right, 1.5, 0.5, right},
                        .information = {1000, 0, 0, 1, 0, 1000, 1, 0, 0, 1000, 0, 1000}};
  const auto solve = [&](EdgeError error) {
    PoseGraphProblem problem(graph, {.error = error});
    B backend;
    B::Vector x = test::Start(problem);
    SolveLm(PoseGraphOptions(), backend, problem, x.view());
    return std::array{x[3], x[4]};
  };
  const auto [x, y] = solve(EdgeError::kG2o);
  EXPECT_NEAR(x, 1.4995, 5e-5);
  EXPECT_NEAR(y, 0.0005, 5e-5);
  const auto [ceres_x, ceres_y] = solve(EdgeError::kCeres);
  EXPECT_NEAR(ceres_x, 1.0005, 5e-5);
  EXPECT_NEAR(ceres_y, 0.4995, 5e-5);
}

TEST(PoseGraphProblem, FixedPosesStay) {
  PoseGraph graph = test::RingGraph<Se3>(8, 0.2, 3);
  graph.fixed = {1, 5};
  PoseGraphProblem problem(graph);
  B backend;
  B::Vector x = test::Start(problem);
  SolveLm(PoseGraphOptions(), backend, problem, x.view());
  for (const Index pose : graph.fixed) {
    for (Index i = 7 * pose; i < 7 * pose + 7; ++i) EXPECT_EQ(x[i], problem.start()[static_cast<std::size_t>(i)]);
  }
  EXPECT_NE(x[0], problem.start()[0]);
}

TEST(PoseGraphProblem, NothingToMoveIsASolvedProblem) {
  PoseGraph graph = test::RingGraph<Se2>(4, 0.2, 4);
  graph.fixed = {0, 1, 2, 3};
  PoseGraphProblem problem(graph);
  B backend;
  B::Vector x = test::Start(problem);
  EXPECT_TRUE(IsConverged(SolveLm(PoseGraphOptions(), backend, problem, x.view()).status));
}

TEST(PoseGraphProblem, PosesWithoutEdgesStayWhereTheyAre) {
  PoseGraph graph = test::RingGraph<Se3>(8, 0.2, 5);
  const double lonely[7] = {1, 2, 3, 1, 0, 0, 0};
  graph.poses.insert(graph.poses.end(), lonely, lonely + 7);
  graph.ids.push_back(999);
  PoseGraphProblem problem(graph);
  B backend;
  B::Vector x = test::Start(problem);
  const LmSummary summary = SolveLm(PoseGraphOptions(), backend, problem, x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_EQ(summary.num_zero_columns, 6);
  for (Index i = 0; i < 7; ++i) EXPECT_NEAR(x[56 + i], lonely[i], 1e-15);
}

TEST(PoseGraphProblem, RefusesGraphsThatDoNotFit) {
  const PoseGraph good = test::RingGraph<Se2>(5, 0.1, 6);
  struct Case {
    std::function<void(PoseGraph&)> spoil;
    std::vector<std::string> tokens;
  };
  for (const auto& [spoil, tokens] :
       std::vector<Case>{{[](PoseGraph& graph) { graph.poses.pop_back(); }, {"14", "5"}},
                         {[](PoseGraph& graph) { graph.fixed = {5}; }, {"5"}},
                         {[](PoseGraph& graph) {
                            graph.edges[2] = {3, 3};
                          },
                          {"2", "3"}},
                         {[](PoseGraph& graph) { graph.edges[1].to = 5; }, {"1", "5"}},
                         {[](PoseGraph& graph) { graph.information[6] = -1; }, {"1", "-1"}}}) {
    PoseGraph bad = good;
    spoil(bad);
    EXPECT_THAT([&] { PoseGraphProblem problem(bad); }, ThrowsErrorWith(kBadArgument, tokens));
  }
  EXPECT_THAT([&] { PoseGraphProblem problem(good, {.max_factor_gib = 0}); },
              ThrowsError(kBadArgument, "max_factor_gib", "0"));
}

TEST(PoseGraphProblem, AQuaternionOfZerosIsNoStart) {
  PoseGraphProblem problem(test::RingGraph<Se3>(8, 0.2, 1));
  B backend;
  B::Vector x = test::Start(problem);
  const ProblemCheck check = CheckProblem<B>(backend, problem, x);
  EXPECT_TRUE(check.ok()) << check.Report();
  std::fill_n(x.data() + 5 * Se3::kPose + 3, 4, 0.0);
  const LmSummary summary = SolveLm<B>(PoseGraphOptions(), backend, problem, x.view());
  EXPECT_EQ(summary.status, LmStatus::kDegenerateStart) << summary.message;
  EXPECT_NE(summary.message.find("pose 5"), std::string::npos) << summary.message;
  EXPECT_THROW(problem.Cost(x.view().subspan(0, 7)), Error);
  EXPECT_THROW(LinearizeAt(problem, x.view().subspan(0, 7)), Error);
}

// The cost is 1/2 e^T Lambda e for both square roots: the symmetric root equals its transpose.
TEST(PoseGraphProblem, SemidefiniteInformationIsUsedAsItIs) {
  PoseGraph graph{.space = PoseSpace::kSe2,
                  .ids = {0, 1},
                  .poses = {0, 0, 0, 3, 1, 0},
                  .edges = {{0, 1}},
                  .measurements = {1, 0, 0},
                  .information = {4, 2, 0, 1, 0, 0}};
  CpuBackend<double>::Vector x(6);
  std::copy(graph.poses.begin(), graph.poses.end(), x.begin());
  for (const EdgeError error : {EdgeError::kG2o, EdgeError::kCeres}) {
    PoseGraphProblem problem(graph, {.error = error});
    // e = (2, 1, 0).
    EXPECT_NEAR(problem.Cost(x), 0.5 * (4 * 4 + 2 * 2 * 2 + 1), 1e-12);
  }
}

}  // namespace
}  // namespace vesta::pose_graph
