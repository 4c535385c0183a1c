// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/block_linearization.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "solver/internal/evaluation_faults.h"
#include "solver/internal/reduced/block_reduced_system.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta {

namespace {
constexpr Index kGrain = 64;
}

BlockLinearization::BlockLinearization(BlockProblem& problem, ConstVectorView x)
    : problem_(problem),
      memory_(problem.memory_),
      jacobian_(problem.Structure(), std::move(memory_.jacobian)),
      residuals_(std::move(memory_.residuals)),
      product_(std::move(memory_.product)) {
  residuals_.ResizeForOverwrite(problem.Structure().num_residuals());
  const auto rows = static_cast<Index>(problem.Structure().rows().size());
  ParallelForChunks(rows, kGrain, [&](Index begin, Index end) {
    Scratch scratch;
    for (Index r = begin; r < end; ++r) EvaluateRow(problem, x, r, scratch);
  });
}

void BlockProblem::LinearizeTerm(ConstVectorView x, std::size_t term, std::span<const BlockCell> cells, int width,
                                 double* residuals, double* jacobian, Scratch& scratch) const {
  const ResidualBlock block = residuals_[term];
  if (!EvaluateTerm(x, term, residuals, scratch)) {
    std::fill_n(residuals, block.num_residuals, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  for (const BlockCell& cell : cells) {
    const auto argument = static_cast<std::size_t>(cell.argument);
    const auto p = static_cast<std::size_t>(block.parameters[argument]);
    const int from = parameters_[p].ambient_size, to = parameters_[p].tangent_size;
    const double* own = scratch.jacobians[argument];
    const Manifold* manifold = manifolds_[p].get();
    if (manifold) {
      scratch.plus_jacobian.assign(static_cast<std::size_t>(from) * static_cast<std::size_t>(to), Unwritten<double>());
      manifold->PlusJacobian(scratch.arguments[argument], scratch.plus_jacobian.data());
    }
    const double* plus = scratch.plus_jacobian.data();
    for (int i = 0; i < block.num_residuals; ++i) {
      double* out = jacobian + i * width + cell.local;
      for (int c = 0; c < to; ++c) {
        if (!manifold) {
          out[c] = own[i * from + c];
          continue;
        }
        double sum = 0;
        for (int a = 0; a < from; ++a) {
          sum += own[i * from + a] * plus[a * to + c];
        }
        out[c] = sum;
      }
    }
  }
}

void BlockLinearization::EvaluateRow(const BlockProblem& problem, ConstVectorView x, Index r, Scratch& scratch) {
  const BlockStructure& structure = jacobian_.structure();
  const BlockRow& row = structure.rows()[static_cast<std::size_t>(r)];
  const auto term = static_cast<std::size_t>(row.residual_block);
  double* f = residuals_.data() + row.residual_offset;
  double* values = jacobian_.row_values(r);
  problem.LinearizeTerm(x, term, structure.cells(row), row.width, f, values, scratch);
  if (const Loss* loss = problem.terms_[term].loss.get()) {
    double s = 0;
    for (int i = 0; i < row.num_residuals; ++i) s += f[i] * f[i];
    LossCorrection(loss->Evaluate(s), s).Apply(row.num_residuals, row.width, f, values, row.width, 1);
  }
}

void BlockLinearization::ApplyH(ConstVectorView v, VectorView Hv) {
  product_.ResizeForOverwrite(num_residuals());
  jacobian_.Apply(v, product_);
  jacobian_.ApplyTranspose(product_, Hv);
}

const BlockMatrix& BlockLinearization::NormalMatrix() {
  if (!normal_matrix_) {
    normal_matrix_ = problem_.options_.dynamic_sparsity ? BlockNormalMatrix(jacobian_).Sum(jacobian_)
                                                        : problem_.NormalMatrix().Sum(jacobian_);
  }
  return *normal_matrix_;
}

std::unique_ptr<ReducedSystem<BlockLinearization::B>> BlockLinearization::MakeReducedSystem() {
  if (jacobian_.structure().num_kept() == jacobian_.structure().num_tangent()) return nullptr;
  return std::make_unique<BlockReducedSystem>(jacobian_, problem_.EliminatedCouplings(),
                                              [this](bool always) { return problem_.PlanReduced(always); });
}

}  // namespace vesta
