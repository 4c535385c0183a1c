// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/block_linearization.h"

#include <limits>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "solver/internal/blocks/block_reduced_system.h"
#include "solver/internal/evaluation_faults.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta {

namespace {
constexpr Index kGrain = 64;
}

BlockLinearization::BlockLinearization(const BlockProblem& problem, ConstVectorView x)
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

void BlockLinearization::EvaluateRow(const BlockProblem& problem, ConstVectorView x, Index r, Scratch& scratch) {
  const BlockStructure& structure = jacobian_.structure();
  const BlockRow& row = structure.rows()[static_cast<std::size_t>(r)];
  const auto term = static_cast<std::size_t>(row.residual_block);
  const std::span<const int> parameters = problem.residuals_[term].parameters;
  double* f = residuals_.data() + row.residual_offset;
  double* values = jacobian_.row_values(r);
  if (!problem.EvaluateTerm(x, term, f, scratch)) {
    for (int i = 0; i < row.num_residuals; ++i) f[i] = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  for (const BlockCell& cell : structure.cells(row)) {
    const auto argument = static_cast<std::size_t>(cell.argument);
    const auto p = static_cast<std::size_t>(parameters[argument]);
    const int from = problem.parameters_[p].ambient_size, to = problem.parameters_[p].tangent_size;
    const double* own = scratch.jacobians[argument];
    const Manifold* manifold = problem.manifolds_[p].get();
    if (manifold) {
      scratch.plus_jacobian.assign(static_cast<std::size_t>(from) * static_cast<std::size_t>(to), Unwritten<double>());
      manifold->PlusJacobian(scratch.arguments[argument], scratch.plus_jacobian.data());
    }
    const double* plus = scratch.plus_jacobian.data();
    for (int i = 0; i < row.num_residuals; ++i) {
      double* out = values + i * row.width + cell.local;
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
  return std::make_unique<BlockReducedSystem>(jacobian_);
}

}  // namespace vesta
