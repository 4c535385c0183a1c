// SPDX-License-Identifier: Apache-2.0
// Divides a BlockProblem into parts for several processes.
#pragma once

#include <vector>

#include "solver/block_problem.h"
#include "solver/distributed/problem_parts.h"

namespace vesta {

// Each part has a consecutive range of the residual blocks with a free parameter block, a range of the other residual
// blocks, and the parameter blocks that these residual blocks use. A part evaluates only its own residual blocks, and
// stores only their Jacobian. Every process creates the whole problem, with all parameter blocks and cost functions.
// The whole problem defines the order of the entries of a step, and the bounds.
class BlockParts final : public ProblemParts<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // num_parts is limited to the number of residual blocks with a free parameter block. `whole` must outlive this object
  // and must not change.
  // Throws Error if num_parts < 1 or if `whole` has an evaluation callback.
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
};

}  // namespace vesta
