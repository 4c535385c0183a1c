// SPDX-License-Identifier: Apache-2.0
#include "solver/covariance.h"

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/linear/dense_qr.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"

namespace vesta {

Covariance EstimateCovariance(Problem<CpuBackend<double>>& of, CpuBackend<double>::ConstVectorView x,
                              const CovarianceOptions& options) {
  constexpr Index kMaxEntries = 100'000'000;
  VESTA_CHECK(options.relative_threshold >= 0 && options.relative_threshold < 1,
              "relative_threshold is {}; choose it within [0, 1)", options.relative_threshold);
  VESTA_CHECK(options.null_space_rank >= -1, "null_space_rank is {}; choose -1 or more", options.null_space_rank);
  const ProblemAdaptor<CpuBackend<double>> problem(of);
  CpuBackend<double> backend;
  std::vector<std::unique_ptr<LinearizationAdaptor<CpuBackend<double>>>> batches;
  std::vector<LinearizationAdaptor<CpuBackend<double>>*> pointers;
  Index rows = 0;
  for (int b = 0; b < problem.num_batches(); ++b) {
    batches.push_back(problem.CheckedLinearize(x, b));
    pointers.push_back(batches.back().get());
    if (batches.back()->weighted()) Fail(kUnsupported, "a covariance needs a problem without weights W");
    rows += batches.back()->num_residuals();
  }
  if (rows * problem.num_tangent() > kMaxEntries) {
    Fail(kUnsupported, "the covariance needs a dense Jacobian, and {} x {} is too large; use EstimateBlockCovariance",
         rows, problem.num_tangent());
  }
  const DenseJacobian dense = MakeDenseJacobian<CpuBackend<double>>(backend, pointers);
  Covariance covariance{.size = dense.cols};
  if (covariance.size == 0) return covariance;
  for (const double entry : dense.jacobian) {
    if (!std::isfinite(entry)) return covariance;
  }
  DenseQr::Inverse inverse =
      DenseQr(dense.rows, dense.cols, dense.jacobian, dense.residuals)
          .NormalInverse(options.relative_threshold, options.null_space_rank, options.scale_columns);
  covariance.rank = inverse.rank;
  covariance.values = std::move(inverse.values);
  return covariance;
}

namespace {

using Pairs = std::span<const std::pair<int, int>>;

// Blocks of zeros, in tangent spaces.
BlockCovariance ZeroBlocks(BlockProblem& problem, CpuBackend<double>::ConstVectorView x, Pairs pairs) {
  VESTA_CHECK(x.size() == problem.num_parameters(), "x has {} entries, but the problem has {} parameters", x.size(),
              problem.num_parameters());
  BlockCovariance covariance;
  for (const auto& [a, b] : pairs) {
    const int rows = problem.tangent_size(a), cols = problem.tangent_size(b);
    covariance.blocks.push_back({rows, cols, std::vector<double>(static_cast<std::size_t>(Index{rows} * cols))});
  }
  return covariance;
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

RowMajor PlusJacobian(const BlockProblem& problem, CpuBackend<double>::ConstVectorView x, int block, int tangent_size) {
  const Manifold* const manifold = problem.manifold(block).get();
  if (manifold == nullptr) return RowMajor::Identity(tangent_size, tangent_size);
  RowMajor jacobian(manifold->ambient_size(), tangent_size);
  manifold->PlusJacobian(x.data() + problem.offset(block), jacobian.data());
  return jacobian;
}

void MoveTo(CovarianceSpace space, const BlockProblem& problem, CpuBackend<double>::ConstVectorView x, Pairs pairs,
            BlockCovariance& covariance) {
  if (space == CovarianceSpace::kTangent) return;
  for (std::size_t k = 0; k < covariance.blocks.size(); ++k) {
    BlockCovariance::Block& block = covariance.blocks[k];
    if (block.values.empty()) continue;
    const RowMajor left = PlusJacobian(problem, x, pairs[k].first, block.rows);
    const RowMajor right = PlusJacobian(problem, x, pairs[k].second, block.cols);
    const RowMajor moved = left * RowMajor::Map(block.values.data(), block.rows, block.cols) * right.transpose();
    block = {static_cast<int>(moved.rows()), static_cast<int>(moved.cols()),
             std::vector<double>(moved.data(), moved.data() + moved.size())};
  }
}

}  // namespace

BlockCovariance EstimateBlockCovariance(BlockProblem& problem, CpuBackend<double>::ConstVectorView x, Pairs pairs,
                                        CovarianceSpace space) {
  using B = CpuBackend<double>;
  BlockCovariance covariance = ZeroBlocks(problem, x, pairs);
  std::map<int, std::vector<std::size_t>> pairs_of_column;  // indices of the pairs, by their second block
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!covariance.blocks[k].values.empty()) pairs_of_column[pairs[k].second].push_back(k);
  }
  if (pairs_of_column.empty()) return covariance;
  LinearizationAdaptor<B> linearization(problem.Linearize(x));
  LinearizationAdaptor<B>* const batches[] = {&linearization};
  const Index n = problem.num_tangent();
  B::Vector diagonal(n), no_damping(n), unit(n), column(n);
  linearization.DiagJTJ(diagonal);
  const auto factor = problem.MakeSparseCholesky();
  auto& cholesky = dynamic_cast<SparseCholeskyPreconditioner&>(*factor);
  cholesky.SetLinearization(batches, diagonal);
  cholesky.SetDamping(0, no_damping);
  covariance.num_singular = B().AllFinite(diagonal) ? cholesky.num_raised() : n;
  if (covariance.num_singular > 0) {
    covariance.blocks.clear();
    return covariance;
  }
  for (const auto& [second, asked] : pairs_of_column) {
    const Index first_column = problem.tangent_offset(second);
    for (int c = 0; c < problem.tangent_size(second); ++c) {
      unit[first_column + c] = 1;
      cholesky.Apply(unit, column);
      unit[first_column + c] = 0;
      for (const std::size_t k : asked) {
        BlockCovariance::Block& block = covariance.blocks[k];
        const Index first_row = problem.tangent_offset(pairs[k].first);
        for (int r = 0; r < block.rows; ++r) {
          block.values[static_cast<std::size_t>(Index{r} * block.cols + c)] = column[first_row + r];
        }
      }
    }
  }
  MoveTo(space, problem, x, pairs, covariance);
  return covariance;
}

BlockCovariance CovarianceBlocks(BlockProblem& problem, CpuBackend<double>::ConstVectorView x, const Covariance& of,
                                 Pairs pairs, CovarianceSpace space) {
  VESTA_CHECK(of.size == problem.num_tangent(), "the covariance has {} rows, but steps of the problem have {} entries",
              of.size, problem.num_tangent());
  BlockCovariance covariance = ZeroBlocks(problem, x, pairs);
  covariance.num_singular = of.size - of.rank;
  if (of.values.empty()) covariance.blocks.clear();
  for (std::size_t k = 0; k < covariance.blocks.size(); ++k) {
    BlockCovariance::Block& block = covariance.blocks[k];
    if (block.values.empty()) continue;
    const auto row = static_cast<int>(problem.tangent_offset(pairs[k].first));
    const auto col = static_cast<int>(problem.tangent_offset(pairs[k].second));
    for (int r = 0; r < block.rows; ++r) {
      for (int c = 0; c < block.cols; ++c) {
        block.values[static_cast<std::size_t>(Index{r} * block.cols + c)] = of(row + r, col + c);
      }
    }
  }
  MoveTo(space, problem, x, pairs, covariance);
  return covariance;
}

}  // namespace vesta
