// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/block_parts.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/ranks/communicator.h"

namespace vesta {
namespace {

// Position of each parameter block's first entry in a step; -1 for constant blocks.
std::vector<Index> TangentOffsets(const BlockStructure& structure, int num_blocks) {
  std::vector<Index> offsets(static_cast<std::size_t>(num_blocks), -1);
  for (const FreeBlock& free : structure.free_blocks()) offsets[static_cast<std::size_t>(free.parameter)] = free.offset;
  return offsets;
}

}  // namespace

BlockParts::BlockParts(BlockProblem& whole, int num_parts) : whole_(whole) {
  if (num_parts < 1) Fail(kBadArgument, "num_parts is {}; choose 1 or more", num_parts);
  if (whole.options_.evaluation_callback) {
    Fail(kUnsupported,
         "a problem with an evaluation callback cannot be split, because parts are evaluated separately; remove the "
         "callback");
  }
  num_parts_ = static_cast<int>(std::clamp<Index>(num_parts, 1, std::max<Index>(whole.num_units(), 1)));
  tangent_offset_ = TangentOffsets(whole.Structure(), whole.num_parameter_blocks());
}

std::vector<BlockGroup> BlockParts::block_groups() const { return whole_.Structure().groups(); }

ProblemPart<CpuBackend<double>> BlockParts::Make(int part) {
  const Share run = ShareOf(whole_.num_units(), num_parts_, part);
  std::vector<int> used;
  for (auto k = static_cast<std::size_t>(run.begin); k < static_cast<std::size_t>(run.end); ++k) {
    const ResidualBlock block = whole_.residuals_[k];
    used.insert(used.end(), block.parameters.begin(), block.parameters.end());
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());

  // Parameter blocks keep their order in the whole problem. No group is moved to the end.
  auto problem = std::make_unique<BlockProblem>(BlockProblem::Options{.eliminate = false});
  ProblemPart<B> made;
  for (const int block : used) {
    const auto k = static_cast<std::size_t>(block);
    const int local = problem->AddParameterBlock(whole_.parameter_block_size(block), whole_.manifolds_[k]);
    if (whole_.constant_[k]) problem->SetConstant(local);
    made.parameters.push_back({problem->offset(local), whole_.offset(block), whole_.parameter_block_size(block)});
  }
  std::vector<int> blocks;
  for (auto k = static_cast<std::size_t>(run.begin); k < static_cast<std::size_t>(run.end); ++k) {
    blocks.clear();
    for (const int block : whole_.residuals_[k].parameters) {
      blocks.push_back(static_cast<int>(std::lower_bound(used.begin(), used.end(), block) - used.begin()));
    }
    problem->AddResidualBlock(whole_.terms_[k].cost, whole_.terms_[k].loss, blocks);
  }
  const std::vector<Index> offsets = TangentOffsets(problem->Structure(), problem->num_parameter_blocks());
  for (std::size_t local = 0; local < used.size(); ++local) {
    if (offsets[local] < 0) continue;
    made.tangent.push_back(
        {offsets[local], tangent_offset_[static_cast<std::size_t>(used[local])], whole_.tangent_size(used[local])});
  }
  made.problem = std::move(problem);
  return made;
}

}  // namespace vesta
