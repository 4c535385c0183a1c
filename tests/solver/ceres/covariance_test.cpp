// SPDX-License-Identifier: Apache-2.0
// Covariances. Adapted from Ceres 2.1's test internal/ceres/covariance_test.cc; docs/ceres_tests.md lists the omitted
// cases. ceres::Covariance computes the expected values.
#include "solver/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "solver/ceres/ceres_problem.h"
#include "tests/solver/ceres/twin_problem.h"

namespace vesta::test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Adds residuals 1, ..., 1 with a constant Jacobian: `rows` rows of each argument, row-major.
void AddLinear(TwinProblem& twin, int rows, std::vector<std::vector<double>> jacobian, const std::vector<int>& blocks) {
  twin.Add(
      rows,
      [rows, jacobian = std::move(jacobian)](const double* const*, double* r, double** j) {
        std::fill_n(r, rows, 1.0);
        for (std::size_t b = 0; j != nullptr && b < jacobian.size(); ++b) {
          if (j[b] != nullptr) std::copy(jacobian[b].begin(), jacobian[b].end(), j[b]);
        }
        return true;
      },
      blocks);
}

// Blocks x (2 numbers), y (3) and z (1) with the Jacobian
//   1  0  0  0  0  0
//   0  1  0  0  0  0
//   0  0  w  0  0  0
//   0  0  0  w  0  0
//   0  0  0  0  w  0
//   0  0  0  0  0  5
//  -5 -6  v 2v 3v  0
//   3 -2  0  0  0  2
// where w = 2 and v = 1, or both are 0.
struct ThreeBlocks : TwinProblem {
  explicit ThreeBlocks(bool rank_deficient = false) {
    AddBlock({1, 1}), AddBlock({2, 2, 2}), AddBlock({3});
    const double w = rank_deficient ? 0 : 2, v = rank_deficient ? 0 : 1;
    AddLinear(*this, 2, {{1, 0, 0, 1}}, {0});
    AddLinear(*this, 3, {{w, 0, 0, 0, w, 0, 0, 0, w}}, {1});
    AddLinear(*this, 1, {{5}}, {2});
    AddLinear(*this, 1, {{v, 2 * v, 3 * v}, {-5, -6}}, {1, 0});
    AddLinear(*this, 1, {{2}, {3, -2}}, {2, 0});
  }
};

std::vector<std::pair<int, int>> AllPairs(int blocks) {
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < blocks; ++a) {
    for (int b = 0; b < blocks; ++b) pairs.emplace_back(a, b);
  }
  return pairs;
}

std::unique_ptr<ceres::Covariance> Compute(TwinProblem& twin, const std::vector<std::pair<int, int>>& pairs,
                                           const ceres::Covariance::Options& options = {}) {
  std::vector<std::pair<const double*, const double*>> addresses;
  for (const auto& [a, b] : pairs) {
    if (a <= b) addresses.emplace_back(twin.values(a), twin.values(b));
  }
  auto covariance = std::make_unique<ceres::Covariance>(options);
  EXPECT_TRUE(covariance->Compute(addresses, &twin.theirs()));
  return covariance;
}

// Our form of Ceres's options.
CovarianceOptions OurOptions(const ceres::Covariance::Options& options) {
  return {.relative_threshold = std::sqrt(options.min_reciprocal_condition_number),
          .null_space_rank = options.null_space_rank,
          .scale_columns = false};
}

// Compares the covariances of all pairs of blocks with Ceres, natively and through the bridge, by the dense and the
// sparse computation, in both spaces. dense_only: directions are ignored.
void ExpectSameCovariances(TwinProblem& twin, const ceres::Covariance::Options& options = {}, bool dense_only = false) {
  const auto pairs = AllPairs(twin.num_blocks());
  const auto theirs = Compute(twin, pairs, options);
  ceres_bridge::CeresProblem bridge(twin.theirs());
  const std::vector<double> x = twin.x();
  const auto bridged_x = bridge.Gather();
  for (BlockProblem* problem : {&twin.ours(), &bridge.problem()}) {
    const bool native = problem == &twin.ours();
    const auto at = native ? View(x) : bridged_x.view();
    auto indices = pairs;
    for (auto& [a, b] : indices) {
      if (!native) a = bridge.block(twin.values(a)), b = bridge.block(twin.values(b));
    }
    const Covariance dense = EstimateCovariance(*problem, at, OurOptions(options));
    ASSERT_FALSE(dense.values.empty());
    for (const CovarianceSpace space : {CovarianceSpace::kTangent, CovarianceSpace::kAmbient}) {
      const BlockCovariance of_dense = CovarianceBlocks(*problem, at, dense, std::span(indices), space);
      const BlockCovariance of_sparse =
          dense_only ? of_dense : EstimateBlockCovariance(*problem, at, std::span(indices), space);
      for (std::size_t p = 0; p < pairs.size(); ++p) {
        const auto [a, b] = indices[p];
        if (problem->tangent_size(a) == 0 || problem->tangent_size(b) == 0) {  // constant
          EXPECT_TRUE(of_dense.blocks.at(p).values.empty());
          EXPECT_TRUE(of_sparse.blocks.at(p).values.empty());
          continue;
        }
        const bool ambient = space == CovarianceSpace::kAmbient;
        const auto size = [&](int block) {
          return ambient ? problem->parameter_block_size(block) : problem->tangent_size(block);
        };
        RowMajor expected(size(a), size(b));
        const double *const first = twin.values(pairs[p].first), *const second = twin.values(pairs[p].second);
        ASSERT_TRUE(ambient ? theirs->GetCovarianceBlock(first, second, expected.data())
                            : theirs->GetCovarianceBlockInTangentSpace(first, second, expected.data()));
        for (const BlockCovariance* ours : {&of_dense, &of_sparse}) {
          const BlockCovariance::Block& block = ours->blocks.at(p);
          ASSERT_EQ(block.rows, expected.rows());
          ASSERT_EQ(block.cols, expected.cols());
          for (int r = 0; r < block.rows; ++r) {
            for (int c = 0; c < block.cols; ++c) EXPECT_NEAR(block(r, c), expected(r, c), 1e-13) << a << ", " << b;
          }
        }
      }
    }
  }
}

// Two numbers that a step scales by one factor: x (+) d = (1 + d) x.
class TheirScaling final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 2; }
  int TangentSize() const override { return 1; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    for (int i = 0; i < 2; ++i) out[i] = (1 + delta[0]) * x[i];
    return true;
  }
  bool PlusJacobian(const double* x, double* j) const override {
    std::copy_n(x, 2, j);
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
};
class OurScaling final : public Manifold {
 public:
  int ambient_size() const override { return 2; }
  int tangent_size() const override { return 1; }
  void Plus(const double* x, const double* delta, double* out) const override { TheirScaling().Plus(x, delta, out); }
  void PlusJacobian(const double* x, double* j) const override { std::copy_n(x, 2, j); }
};

void SetManifolds(TwinProblem& twin) {
  twin.SetManifold(0, {std::make_shared<TheirScaling>(), std::make_shared<OurScaling>()});
  twin.SetManifold(1, {std::make_shared<ceres::SubsetManifold>(3, std::vector<int>{2}),
                       std::make_shared<SubsetManifold>(3, std::vector<int>{2})});
}

TEST(CeresCasesCovariance, OfAllBlocks) {
  ThreeBlocks twin;
  for (const int threads : {1, 4}) {
    for (const ceres::CovarianceAlgorithmType type : {ceres::DENSE_SVD, ceres::SPARSE_QR}) {
      ceres::Covariance::Options options;
      options.algorithm_type = type;
      options.num_threads = threads;
      ExpectSameCovariances(twin, options);
    }
  }
}

TEST(CeresCasesCovariance, BesideAConstantBlock) {
  ThreeBlocks twin;
  twin.SetConstant(0);
  ExpectSameCovariances(twin);
}

TEST(CeresCasesCovariance, OnManifolds) {
  ThreeBlocks twin;
  SetManifolds(twin);
  ExpectSameCovariances(twin);
}

TEST(CeresCasesCovariance, OnManifoldsBesideConstantBlocks) {
  ThreeBlocks twin;
  SetManifolds(twin);
  twin.SetConstant(0);
  twin.SetConstant(1);
  ExpectSameCovariances(twin);
}

// The pseudo-inverse, where the three numbers of y have no effect.
TEST(CeresCasesCovariance, OfARankDeficientProblem) {
  ThreeBlocks twin(true);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = -1;
  ExpectSameCovariances(twin, options, true);
  const std::vector<double> x = twin.x();
  const auto at = View(x);
  EXPECT_EQ(EstimateCovariance(twin.ours(), at).rank, 3);
  EXPECT_TRUE(EstimateCovariance(twin.ours(), at).values.empty());
  const std::pair<int, int> pair(0, 0);
  EXPECT_EQ(EstimateBlockCovariance(twin.ours(), at, std::span(&pair, 1)).num_singular, 3);
  const BlockCovariance none =
      CovarianceBlocks(twin.ours(), at, EstimateCovariance(twin.ours(), at), std::span(&pair, 1));
  EXPECT_EQ(none.num_singular, 3);
  EXPECT_TRUE(none.blocks.empty());
  EXPECT_THROW(CovarianceBlocks(twin.ours(), at, {.size = 2}, std::span(&pair, 1)), Error);
}

// The direction with the smallest singular value is ignored, by its number or by the threshold.
TEST(CeresCasesCovariance, OfTruncatedRank) {
  ThreeBlocks twin;
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = 1;
  ExpectSameCovariances(twin, options, true);
  options.null_space_rank = -1;
  options.min_reciprocal_condition_number = 0.044494;
  ExpectSameCovariances(twin, options, true);
  const std::vector<double> x = twin.x();
  EXPECT_EQ(EstimateCovariance(twin.ours(), View(x), OurOptions(options)).rank, 5);
  // Without ignored directions this threshold leaves no values, as in Ceres.
  options.null_space_rank = 0;
  EXPECT_TRUE(EstimateCovariance(twin.ours(), View(x), OurOptions(options)).values.empty());
  const std::vector<std::pair<const double*, const double*>> pair = {{twin.values(0), twin.values(0)}};
  EXPECT_FALSE(ceres::Covariance(options).Compute(pair, &twin.theirs()));
}

// Ceres keeps a set of blocks in the order of the call; vesta has the order of tangent_offset.
TEST(CeresCasesCovariance, MatrixOfASetOfBlocks) {
  for (const bool manifolds : {false, true}) {
    ThreeBlocks twin;
    if (manifolds) SetManifolds(twin);
    const std::vector<const double*> blocks = {twin.values(0), twin.values(1), twin.values(2)};
    ceres::Covariance theirs({});
    ASSERT_TRUE(theirs.Compute(blocks, &twin.theirs()));
    const std::vector<double> x = twin.x();
    const Covariance ours = EstimateCovariance(twin.ours(), View(x));
    const int size = manifolds ? 4 : 6;
    ASSERT_EQ(ours.size, size);
    RowMajor expected(size, size);
    ASSERT_TRUE(theirs.GetCovarianceMatrixInTangentSpace(blocks, expected.data()));
    std::vector<int> order;
    for (int block = 0; block < 3; ++block) {
      for (int k = 0; k < twin.ours().tangent_size(block); ++k) {
        order.push_back(static_cast<int>(twin.ours().tangent_offset(block)) + k);
      }
    }
    for (int r = 0; r < size; ++r) {
      for (int c = 0; c < size; ++c) EXPECT_NEAR(ours(order[r], order[c]), expected(r, c), 1e-13);
    }
  }
}

// A block whose manifold has no tangent beside one with residuals 10 - x and 5 - y.
TEST(CeresCasesCovariance, BesideABlockWithoutTangent) {
  TwinProblem twin;
  twin.AddBlock({0}), twin.AddBlock({1});
  AddLinear(twin, 2, {{-1, 0}, {0, -1}}, {0, 1});
  ceres::SubsetManifold all(1, {0});
  twin.theirs().SetManifold(twin.values(1), &all);
  twin.ours().SetConstant(1);
  ExpectSameCovariances(twin);
}

// A thousand blocks, block k with the Jacobian (k + 1) I.
TEST(CeresCasesCovariance, OfAThousandBlocks) {
  constexpr int kBlocks = 1000, kSize = 5;
  TwinProblem twin;
  std::vector<std::pair<int, int>> pairs;
  for (int k = 0; k < kBlocks; ++k) {
    twin.AddBlock(std::vector<double>(kSize));
    std::vector<double> jacobian(kSize * kSize);
    for (std::size_t i = 0; i < kSize; ++i) jacobian[i * (kSize + 1)] = k + 1;
    AddLinear(twin, kSize, {jacobian}, {k});
    pairs.emplace_back(k, k);
    if (k > 0) pairs.emplace_back(k - 1, k);
  }
  const std::vector<double> x = twin.x();
  const BlockCovariance covariance = EstimateBlockCovariance(twin.ours(), View(x), std::span(pairs));
  EXPECT_EQ(covariance.num_singular, 0);
  ASSERT_EQ(covariance.blocks.size(), pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const double scale = 1 / std::pow(pairs[p].first + 1, 2);
    for (int r = 0; r < kSize; ++r) {
      for (int c = 0; c < kSize; ++c) {
        EXPECT_NEAR(covariance.blocks[p](r, c), pairs[p].first == pairs[p].second && r == c ? scale : 0, 1e-14 * scale);
      }
    }
  }
}

}  // namespace
}  // namespace vesta::test
