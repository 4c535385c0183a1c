// SPDX-License-Identifier: Apache-2.0
// Problems that are sums of parts, to be distributed over processes. A part uses some of the parameters.
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "solver/problem.h"

namespace vesta {

// Maps entries local .. local + size - 1 of a part to whole .. whole + size - 1 of the whole problem.
struct PartSegment {
  Index local = 0, whole = 0, size = 0;
};

template <Backend B>
struct ProblemPart {
  std::unique_ptr<Problem<B>> problem;
  // Positions of the part's parameters in x, and of its step entries in a step of the whole problem. Each entry of the
  // part occurs once. Empty if the part has all entries, in the same order.
  std::vector<PartSegment> parameters, tangent;
};

// A problem whose cost is the sum over its parts. Each process creates only its own parts.
template <Backend B>
class ProblemParts {
 public:
  virtual ~ProblemParts() = default;

  // Must not depend on the number of processes, because it determines the order of sums. Must be at least the number of
  // processes. 64 suits most problems.
  virtual int num_parts() const = 0;
  // `part`: 0 to num_parts() - 1.
  virtual ProblemPart<B> Make(int part) = 0;
  // The sizes of x and of a step of the whole problem.
  virtual Index num_parameters() const = 0;
  virtual Index num_tangent() const { return num_parameters(); }
  // Block groups of the whole problem, for block Jacobi; empty: none. Each block of a part must be one of these blocks.
  virtual std::vector<BlockGroup> block_groups() const { return {}; }
  // A problem with the functions of the whole problem that are not sums over parts: steps, norms, bounds, the damping
  // metric and names. Its cost and linearization are never used. Null means the defaults of
  // solver/problem_interfaces.h. All calls must return the same object, which must outlive the distributed problem.
  virtual Problem<B>* geometry() { return nullptr; }
  // True if parameters can be eliminated part by part (WithReducedSystem of the parts). Each part's last parameters are
  // then a block-diagonal group that no other part uses. Its other parameters are the same in all parts, and are the
  // first parameters of the whole problem.
  virtual bool eliminates() const { return false; }
};

}  // namespace vesta
