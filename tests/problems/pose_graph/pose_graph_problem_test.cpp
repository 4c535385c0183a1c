// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/pose_graph_problem.h"

#include <gtest/gtest.h>

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
TYPED_TEST(PoseGraphDerivatives, LowerWhitening) { this->Check({.whitening = Whitening::kLower}, {}); }
TYPED_TEST(PoseGraphDerivatives, RobustLoss) { this->Check({.loss = std::make_shared<HuberLoss>(0.5)}, {}); }
TYPED_TEST(PoseGraphDerivatives, FixedPoses) { this->Check({}, {2, 3, 13}); }

TEST(PoseGraphProblem, CostIsTheInformationMatricesQuadraticForm) {
  const PoseGraph graph = test::RingGraph<Se2>(9, 0.3, 2);
  PoseGraphProblem problem(graph);
  double expected = 0;
  std::vector<double> parts;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    double r[3];
    Se2::Residual(graph.poses.data() + 3 * graph.edges[e].from, graph.poses.data() + 3 * graph.edges[e].to,
                  graph.measurements.data() + 3 * e, r);
    const double* w = graph.information.data() + 6 * e;
    parts.push_back(0.5 * (w[0] * r[0] * r[0] + w[3] * r[1] * r[1] + w[5] * r[2] * r[2]) + w[1] * r[0] * r[1] +
                    w[2] * r[0] * r[2] + w[4] * r[1] * r[2]);
    expected += parts.back();
  }
  const B::Vector x = test::Start(problem);
  EXPECT_NEAR(problem.Cost(x), expected, 1e-12 * expected);
  EXPECT_EQ(problem.num_units(), graph.num_edges());
  const Index units[] = {1, 4};
  EXPECT_NEAR(problem.Cost(x, units), parts[1] + parts[4], 1e-12 * expected);
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
  for (const Whitening whitening : {Whitening::kUpper, Whitening::kLower}) {
    PoseGraphProblem problem(graph, {.whitening = whitening});
    // e = (2, 1, 0).
    EXPECT_NEAR(problem.Cost(x), 0.5 * (4 * 4 + 2 * 2 * 2 + 1), 1e-12);
  }
}

}  // namespace
}  // namespace vesta::pose_graph
