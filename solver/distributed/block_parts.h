// SPDX-License-Identifier: Apache-2.0
// A problem of residual blocks cut into parts, to be spread over processes.
#pragma once

#include <vector>

#include "solver/block_problem.h"
#include "solver/distributed/problem_parts.h"

namespace vesta {

// Each part has a run of the residual blocks, as they were added, and the parameter blocks that those use: what it
// evaluates, its Jacobian and its products are its own. All processes make the same whole problem, which holds
// parameter blocks, cost functions and the order of steps. Bounds, manifolds and constant blocks are the whole's.
class BlockParts final : public ProblemParts<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // No more parts than there are residual blocks. whole must outlive this object, and stay as it is. Throws Error for
  // num_parts < 1, and where it has an evaluation callback: parts are evaluated each by itself.
  BlockParts(BlockProblem& whole, int num_parts);

  int num_parts() const override { return num_parts_; }
  ProblemPart<B> Make(int part) override;
  Index num_parameters() const override { return whole_.num_parameters(); }
  Index num_tangent() const override { return whole_.num_tangent(); }
  std::vector<BlockGroup> block_groups() const override;
  Problem<B>* geometry() override { return &whole_; }

 private:
  BlockProblem& whole_;
  int num_parts_;
  std::vector<Index> tangent_offset_;  // of each parameter block of the whole; -1 where it is constant
};

}  // namespace vesta
