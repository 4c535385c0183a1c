// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/reduced/reduced_matrix.h"

#include <algorithm>
#include <vector>

namespace vesta {
namespace {

// Returns the off-diagonal blocks of S, each once. Two kept blocks have a block if they share a residual block, or if
// both share residual blocks with the same eliminated block. Returns fewer than all if there are more than max_pairs.
std::vector<BlockPattern::Pair> Pairs(const BlockStructure& structure, const Couplings& couplings, double max_pairs) {
  std::vector<BlockPattern::Pair> pairs;
  std::vector<int> last(static_cast<std::size_t>(structure.num_kept_blocks()), -1);
  for (int k = 0; k < structure.num_kept_blocks() && static_cast<double>(pairs.size()) <= max_pairs; ++k) {
    const auto add = [&](int other) {
      if (other >= k || last[static_cast<std::size_t>(other)] == k) return;
      last[static_cast<std::size_t>(other)] = k;
      pairs.push_back({k, other});
    };
    for (const Coupling& own : couplings.of_kept(k)) {
      for (const CoupledKept& other : couplings.of_eliminated(own.eliminated)) add(other.kept);
    }
    for (const BlockUse& use : structure.uses(k)) {
      const BlockRow& row = structure.rows()[static_cast<std::size_t>(use.row)];
      // If the row has an eliminated block, its kept blocks were added above.
      if (row.eliminated_cell >= 0) continue;
      for (const BlockCell& cell : structure.cells(row)) add(cell.free);
    }
  }
  return pairs;
}

}  // namespace

std::shared_ptr<ReducedMatrixPlan> ReducedMatrixPlan::Make(const BlockStructure& structure, const Couplings& couplings,
                                                           double max_bytes, double max_multiplications,
                                                           ExceededLimit* exceeded) {
  // A pair, its block in the pattern, and temporary memory.
  constexpr double kBytesPerPair = 2 * sizeof(BlockPattern::Pair) + 6 * sizeof(Index);
  const double max_pairs = max_bytes / kBytesPerPair;
  const std::vector<BlockPattern::Pair> pairs = Pairs(structure, couplings, max_pairs);
  if (static_cast<double>(pairs.size()) > max_pairs) {
    if (exceeded) *exceeded = ExceededLimit::kFactorValues;
    return nullptr;
  }
  std::vector<int> sizes;
  sizes.reserve(static_cast<std::size_t>(structure.num_kept_blocks()));
  for (int k = 0; k < structure.num_kept_blocks(); ++k) {
    sizes.push_back(structure.free_blocks()[static_cast<std::size_t>(k)].size);
  }
  std::shared_ptr<ReducedMatrixPlan> plan(new ReducedMatrixPlan);
  plan->pattern_ = std::make_shared<const BlockPattern>(sizes, pairs);
  plan->num_coupling_values_ = couplings.num_values();
  const double values = static_cast<double>(plan->num_coupling_values_) +
                        static_cast<double>(plan->pattern_->diagonal_value(plan->pattern_->num_rows())) +
                        static_cast<double>(plan->pattern_->block_value(plan->pattern_->num_blocks()));
  if (values * sizeof(double) > max_bytes) {
    if (exceeded) *exceeded = ExceededLimit::kFactorValues;
    return nullptr;
  }
  plan->cholesky_ = SparseCholesky::Plan(*plan->pattern_, max_bytes, max_multiplications, exceeded);
  return plan->cholesky_ ? plan : nullptr;
}

double ReducedMatrixPlan::Multiplications(const BlockStructure& structure, const Couplings& couplings) {
  double sum = 0;
  for (const BlockRow& row : structure.rows()) {
    double kept = row.width;
    if (row.eliminated_cell >= 0) {
      kept -= structure.cells(row)[static_cast<std::size_t>(row.eliminated_cell)].size;
      sum += row.num_residuals * kept * (row.width - kept);
    }
    sum += 0.5 * row.num_residuals * kept * (kept + 1);
  }
  const auto num_kept = static_cast<std::size_t>(structure.num_kept_blocks());
  for (std::size_t e = 0; num_kept + e < structure.free_blocks().size(); ++e) {
    double kept = 0;
    for (const CoupledKept& coupled : couplings.of_eliminated(static_cast<int>(e))) {
      kept += structure.free_blocks()[static_cast<std::size_t>(coupled.kept)].size;
    }
    sum += 0.5 * structure.free_blocks()[num_kept + e].size * kept * (kept + 1);
  }
  return sum;
}

std::shared_ptr<ReducedMatrixPlan::Memory> ReducedMatrixPlan::GetMemory() {
  return memory_.Get([&] {
    return std::make_shared<Memory>(
        Memory{FactoredMatrix(pattern_, *cholesky_), CpuBackend<double>::Vector(num_coupling_values_)});
  });
}

}  // namespace vesta
