// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/block_parts.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/ranks/communicator.h"

namespace vesta {

BlockParts::BlockParts(BlockProblem& whole, int num_parts) : whole_(whole) {
  if (num_parts < 1) Fail(kBadArgument, "num_parts is {}; choose 1 or more", num_parts);
  if (whole.options_.evaluation_callback) {
    Fail(kUnsupported,
         "a problem with an evaluation callback cannot be split, because parts are evaluated separately; remove the "
         "callback");
  }
  num_parts_ = static_cast<int>(std::clamp<Index>(num_parts, 1, std::max<Index>(whole.num_units(), 1)));
}

std::vector<BlockGroup> BlockParts::block_groups() const { return whole_.Structure().groups(); }

ProblemPart<CpuBackend<double>> BlockParts::Make(int part) {
  const BlockStructure& structure = whole_.Structure();
  std::vector<std::size_t> terms;
  const Share rows = ShareOf(whole_.num_units(), num_parts_, part);
  for (Index r = rows.begin; r < rows.end; ++r) {
    terms.push_back(static_cast<std::size_t>(structure.rows()[static_cast<std::size_t>(r)].residual_block));
  }
  const std::vector<Index>& fixed = structure.fixed_residual_blocks();
  const Share of_fixed = ShareOf(static_cast<Index>(fixed.size()), num_parts_, part);
  terms.insert(terms.end(), fixed.begin() + of_fixed.begin, fixed.begin() + of_fixed.end);
  std::vector<int> used;
  for (const std::size_t k : terms) {
    const ResidualBlock block = whole_.residuals_[k];
    used.insert(used.end(), block.parameters.begin(), block.parameters.end());
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());

  // Parameter blocks keep their order in the whole problem.
  auto problem = std::make_unique<BlockProblem>(BlockProblem::Options{.eliminate = false});
  ProblemPart<B> made;
  for (const int block : used) {
    const auto k = static_cast<std::size_t>(block);
    const int local = problem->AddParameterBlock(whole_.parameter_block_size(block), whole_.manifolds_[k]);
    if (whole_.constant_[k]) problem->SetConstant(local);
    made.parameters.push_back({problem->offset(local), whole_.offset(block), whole_.parameter_block_size(block)});
  }
  std::vector<int> blocks;
  for (const std::size_t k : terms) {
    blocks.clear();
    for (const int block : whole_.residuals_[k].parameters) {
      blocks.push_back(static_cast<int>(std::lower_bound(used.begin(), used.end(), block) - used.begin()));
    }
    problem->AddResidualBlock(whole_.terms_[k].cost, whole_.terms_[k].loss, blocks);
  }
  for (std::size_t local = 0; local < used.size(); ++local) {
    const FreeBlock* const free = problem->Structure().Find(static_cast<int>(local));
    if (free) made.tangent.push_back({free->offset, structure.Find(used[local])->offset, free->size});
  }
  made.problem = std::move(problem);
  return made;
}

}  // namespace vesta
