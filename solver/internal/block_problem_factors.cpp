// SPDX-License-Identifier: Apache-2.0
// The Cholesky factors of a BlockProblem: of H, and of the reduced system. Each is planned only if it may be used.
#include <fmt/format.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "solver/block_problem.h"
#include "solver/internal/reduced/couplings.h"
#include "solver/internal/reduced/reduced_matrix.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta {

template <class Plan>
std::shared_ptr<Plan> BlockProblem::Planned(std::shared_ptr<Plan> plan) const {
  if (plan) return plan;
  Fail(kOutOfMemory,
       "preconditioner = {}: the factor would be larger than max_factor_gib = {}; raise it or choose kBlockJacobi",
       ToString(PreconditionerKind::kSparseCholesky), options_.max_factor_gib);
}

std::unique_ptr<Preconditioner<BlockProblem::B>> BlockProblem::MakePreconditioner() {
  if (options_.make_preconditioner) return options_.make_preconditioner();
  if (options_.dynamic_sparsity) return MakeSparseCholesky();
  const StepCounts& counts = *CountSteps(false);
  if (!FactorBeatsIterations(counts)) {
    return std::make_unique<BlockJacobiPreconditioner<B>>(" (" + WhyNoFactor(counts) + ")");
  }
  const double cost = IterationsCost(counts);
  return std::make_unique<SparseCholeskyPreconditioner>(
      cholesky_, fmt::format(" ({}{})", FactorCost(*counts.factor, counts) > cost ? "no fill, " : "",
                             CompareFactorCost(counts, DescribeIterations(counts), cost)));
}

StepCounts::Factor BlockProblem::LeastFactor() const {
  const BlockStructure& structure = Structure();
  StepCounts::Factor least{.sums = BlockNormalMatrix::Multiplications(structure)};
  // Each eliminated block is a front. It passes to its parent a matrix over the kept blocks that it shares residuals
  // with.
  std::vector<int> last_user(structure.free_blocks().size(), -1);
  for (int e = structure.num_kept_blocks(); e < static_cast<int>(structure.free_blocks().size()); ++e) {
    double below = 0;
    for (const BlockUse& use : structure.uses(e)) {
      for (const BlockCell& cell : structure.cells(structure.rows()[static_cast<std::size_t>(use.row)])) {
        if (std::exchange(last_user[static_cast<std::size_t>(cell.free)], e) != e)
          below += cell.free == e ? 0 : cell.size;
      }
    }
    least.updates += below * below;
    least.fronts += 1;
  }
  return least;
}

const StepCounts* BlockProblem::CountSteps(bool eliminating) {
  if (options_.make_preconditioner || options_.dynamic_sparsity) return nullptr;
  const BlockStructure& structure = Structure();
  const bool reduced = eliminating && structure.num_kept() < structure.num_tangent();
  if (counts_ && counts_->reduced == reduced) return &*counts_;
  counts_.emplace(
      StepCounts{.residuals = static_cast<double>(structure.num_residuals()),
                 .columns = static_cast<double>(structure.num_tangent()),
                 .entries = static_cast<double>(structure.num_values()),
                 .reduced = reduced,
                 .system_columns = static_cast<double>(reduced ? structure.num_kept() : structure.num_tangent()),
                 .hops = static_cast<double>(LongestDistanceLowerBound(structure))});
  const StepCounts::Factor least =
      reduced ? StepCounts::Factor{.sums = ReducedMatrixPlan::Multiplications(structure, EliminatedCouplings())}
              : LeastFactor();
  const double allowed = MaxFactorMultiplications(*counts_, least);
  if (allowed > 0) {
    ExceededLimit exceeded = ExceededLimit::kNone;
    if (reduced && !reduced_matrix_) {
      reduced_matrix_ = ReducedMatrixPlan::Make(structure, EliminatedCouplings(), MaxFactorBytes(), allowed, &exceeded);
    } else if (!reduced && !cholesky_) {
      cholesky_ = PlanCholesky(allowed, &exceeded);
    }
    counts_->exceeded_gib = exceeded == ExceededLimit::kFactorValues ? options_.max_factor_gib : 0;
  }
  const SparseCholesky* const cholesky = !reduced          ? cholesky_.get()
                                         : reduced_matrix_ ? &reduced_matrix_->cholesky()
                                                           : nullptr;
  if (cholesky) {
    const EliminationPlan& plan = cholesky->plan();
    counts_->factor = {.sums = least.sums,
                       .multiplications = plan.multiplications,
                       .values = plan.factor_values,
                       .updates = plan.update_values,
                       .fronts = static_cast<double>(plan.fronts.size())};
  }
  return &*counts_;
}

std::shared_ptr<ReducedMatrixPlan> BlockProblem::PlanReduced(bool always) {
  if (!always) {
    const StepCounts* const counts = CountSteps(true);
    return counts && FactorBeatsIterations(*counts) ? reduced_matrix_ : nullptr;
  }
  if (!reduced_matrix_) {
    constexpr double kNoLimit = std::numeric_limits<double>::infinity();
    reduced_matrix_ = Planned(ReducedMatrixPlan::Make(Structure(), EliminatedCouplings(), MaxFactorBytes(), kNoLimit));
  }
  return reduced_matrix_;
}

std::unique_ptr<Preconditioner<BlockProblem::B>> BlockProblem::MakeSparseCholesky() {
  if (options_.dynamic_sparsity) {
    return std::make_unique<SparseCholeskyPreconditioner>(
        [this](const BlockPattern& pattern) { return Planned(SparseCholesky::Plan(pattern, MaxFactorBytes())); });
  }
  if (!cholesky_) cholesky_ = Planned(PlanCholesky(std::numeric_limits<double>::infinity()));
  return std::make_unique<SparseCholeskyPreconditioner>(cholesky_);
}

BlockNormalMatrix& BlockProblem::NormalMatrix() const {
  if (!normal_matrix_) normal_matrix_ = std::make_shared<BlockNormalMatrix>(Structure());
  return *normal_matrix_;
}

const Couplings& BlockProblem::EliminatedCouplings() const {
  if (!couplings_) couplings_ = std::make_shared<const Couplings>(Structure());
  return *couplings_;
}

double BlockProblem::MaxFactorBytes() const {
  if (!(options_.max_factor_gib > 0)) {
    Fail(kBadArgument, "max_factor_gib is {}; choose more than 0", options_.max_factor_gib);
  }
  return options_.max_factor_gib * 0x1p30;
}

std::shared_ptr<SparseCholesky> BlockProblem::PlanCholesky(double max_multiplications, ExceededLimit* exceeded) const {
  const double max_bytes = MaxFactorBytes();
  if (BlockNormalMatrix::Bytes(Structure()) > max_bytes) {
    if (exceeded) *exceeded = ExceededLimit::kFactorValues;
    return nullptr;
  }
  return SparseCholesky::Plan(NormalMatrix().pattern(), max_bytes, max_multiplications, exceeded);
}

}  // namespace vesta
