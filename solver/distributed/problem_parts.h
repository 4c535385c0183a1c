// SPDX-License-Identifier: Apache-2.0
// Problems that are sums of parts, so that they can be distributed over processes. Each part is a problem over some of
// the parameters.
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "solver/problem.h"

namespace vesta {

// Maps entries local .. local + size - 1 of a part to entries whole .. whole + size - 1 of the whole problem.
struct PartSegment {
  Index local = 0, whole = 0, size = 0;
};

template <Backend B>
struct ProblemPart {
  std::unique_ptr<Problem<B>> problem;
  // Position of the part's parameters in x, and of its step entries in a step of the whole; each entry once. Empty if
  // the part has all of them in the same order.
  std::vector<PartSegment> parameters, tangent;
};

// The cost is the sum of the parts' costs. A process creates only its own parts.
template <Backend B>
class ProblemParts {
 public:
  virtual ~ProblemParts() = default;

  // Must not depend on the number of processes, because it determines the order of sums. 64 suits most problems.
  virtual int num_parts() const = 0;
  virtual ProblemPart<B> Make(int part) = 0;
  virtual Index num_parameters() const = 0;
  virtual Index num_tangent() const { return num_parameters(); }
  // Block groups of the whole problem; empty means no groups. The blocks of a part must be blocks of these.
  virtual std::vector<BlockGroup> block_groups() const { return {}; }
  // The functions of the whole problem that are not sums: steps, bounds, the damping metric and names. Null means the
  // defaults of solver/problem_interfaces.h. Its costs and linearizations are never used. Returns the same object at
  // every call; it must outlive the distributed problem.
  virtual Problem<B>* geometry() { return nullptr; }
  // True if each part's last parameters are a block-diagonal group that no other part uses. The other parameters must
  // be the first ones of the whole, the same in all parts. The group is then eliminated part by part (WithReducedSystem
  // of the parts).
  virtual bool eliminates() const { return false; }
};

}  // namespace vesta
