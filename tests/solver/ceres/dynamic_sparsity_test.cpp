// SPDX-License-Identifier: Apache-2.0
// A problem whose Jacobian has different nonzeros at each point: a closed polygon is fitted to points of an ellipse.
// Adapted from Ceres 2.1's test internal/ceres/dynamic_sparsity_test.cc, with fewer points.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "tests/solver/ceres/twin_problem.h"

namespace vesta::test {
namespace {

constexpr int kSegments = 41, kPoints = 60;

// Difference of two points, times the weight.
struct Pull {
  double weight;
  template <class T>
  bool operator()(const T* a, const T* b, T* r) const {
    for (int i = 0; i < 2; ++i) r[i] = T(weight) * (a[i] - b[i]);
    return true;
  }
};

// The distance of a point to the polygon at position t. Vertex floor(t) and the next one have the weights 1 - u and u,
// where u = t - floor(t). The arguments are t and all vertices.
Evaluation PointToPolygon(double x, double y) {
  return [x, y](const double* const* p, double* r, double** j) {
    const double t = p[0][0] - kSegments * std::floor(p[0][0] / kSegments);
    const int first = static_cast<int>(t) % kSegments, second = (first + 1) % kSegments;
    const double u = t - std::floor(t), point[] = {x, y};
    for (int i = 0; i < 2; ++i) {
      const double a = p[1 + first][i], b = p[1 + second][i];
      r[i] = point[i] - ((1 - u) * a + u * b);
      if (j != nullptr && j[0] != nullptr) j[0][i] = a - b;
    }
    for (int k = 0; j != nullptr && k < kSegments; ++k) {
      if (j[1 + k] == nullptr) continue;
      const double weight = k == first ? 1 - u : k == second ? u : 0;
      j[1 + k][0] = j[1 + k][3] = -weight;
      j[1 + k][1] = j[1 + k][2] = 0;
    }
    return true;
  };
}

// The polygon starts on the unit circle. Each point starts at the closest vertex.
struct EllipseFit : TwinProblem {
  explicit EllipseFit(BlockProblem::Options options = {}) : TwinProblem(nullptr, std::move(options)) {
    std::vector<int> arguments = {0};
    std::vector<std::pair<double, double>> vertices;
    for (int k = 0; k < kSegments; ++k) {
      const double angle = 2 * std::numbers::pi * k / kSegments;
      vertices.emplace_back(std::cos(angle), std::sin(angle));
      arguments.push_back(AddBlock({vertices.back().first, vertices.back().second}));
    }
    for (int i = 0; i < kPoints; ++i) {
      // An ellipse with the semi-axes 4 and 1, turned by 0.26 rad.
      const double angle = 2 * std::numbers::pi * (i + 0.3 * std::sin(3.0 * i)) / kPoints;
      const double u = 4 * std::cos(angle), v = std::sin(angle), c = std::cos(0.26), s = std::sin(0.26);
      const double x = c * u - s * v, y = s * u + c * v;
      int closest = 0;
      double least = std::numeric_limits<double>::infinity();
      for (int k = 0; k < kSegments; ++k) {
        const auto& [vx, vy] = vertices[static_cast<std::size_t>(k)];
        if (const double distance = std::hypot(x - vx, y - vy); distance < least) closest = k, least = distance;
      }
      arguments[0] = AddBlock({static_cast<double>(closest)});
      Add(2, PointToPolygon(x, y), arguments);
    }
    for (int k = 0; k < kSegments; ++k) Add<2, 2, 2>(Pull{0.1}, {k, (k + 1) % kSegments});
  }
};

TEST(CeresCasesDynamicSparsity, ReachesTheSameMinimum) {
  EllipseFit fit;
  ceres::Solver::Options options = Quiet(ceres::SPARSE_NORMAL_CHOLESKY);
  options.max_num_iterations = 100;
  const Solved expected = fit.Solve(Way::kCeres, options);
  ASSERT_TRUE(expected.converged) << expected.report;
  options.dynamic_sparsity = true;
  const Solved dynamic = fit.Solve(Way::kCeres, options);
  EXPECT_NEAR(dynamic.final_cost, expected.final_cost, 1e-12);
  for (const Way way : kOurWays) {
    SCOPED_TRACE(ToString(way));
    const Solved solved = fit.Solve(way, options);
    EXPECT_TRUE(solved.converged) << solved.report;
    EXPECT_NEAR(solved.final_cost, expected.final_cost, 1e-5 * expected.final_cost);
  }
}

// Zero blocks change nothing but the size of the factor.
TEST(CeresCasesDynamicSparsity, LeavesOutZeroBlocks) {
  EllipseFit fixed, changing({.dynamic_sparsity = true});
  LmOptions options = ceres_bridge::FromCeres(Quiet(ceres::SPARSE_NORMAL_CHOLESKY));
  std::vector<double> x = fixed.x();
  const LmSummary expected = SolveLm(fixed.ours(), x, options);
  std::vector<double> x_changing = fixed.x();
  const LmSummary summary = SolveLm(changing.ours(), x_changing, options);
  EXPECT_EQ(summary.iterations.size(), expected.iterations.size());
  for (std::size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(x_changing[k], x[k], 1e-6);
  const auto at = changing.ours().Linearize(View(x));
  const auto whole = fixed.ours().Linearize(View(x));
  const BlockMatrix& sparse = dynamic_cast<NormalMatrixSource&>(*at).NormalMatrix();
  const BlockMatrix& dense = dynamic_cast<NormalMatrixSource&>(*whole).NormalMatrix();
  // Each point has two vertices, and each vertex the next one.
  EXPECT_LE(sparse.pattern().num_blocks(), 2 * kPoints + 2 * kSegments);
  EXPECT_GE(dense.pattern().num_blocks(), kPoints * kSegments);
}

// PCG uses the factor without being told so.
TEST(CeresCasesDynamicSparsity, ByDefaultThePreconditionerIsTheFactor) {
  EllipseFit fit({.max_factor_gib = 1e-9, .dynamic_sparsity = true});
  std::vector<double> x = fit.x();
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  EXPECT_THROW(SolveLm(fit.ours(), x, options), Error) << "the factor exceeds its limit";
  EllipseFit roomy({.dynamic_sparsity = true});
  EXPECT_TRUE(IsConverged(SolveLm(roomy.ours(), x, options).status));
}

}  // namespace
}  // namespace vesta::test
