// SPDX-License-Identifier: Apache-2.0
// Problems that are a sum of parts, each a problem of its own over some of the parameters: what can be spread over
// processes.
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "solver/problem.h"

namespace vesta {

// Entries local .. local + size - 1 of a part are whole .. whole + size - 1 of the whole.
struct PartSegment {
  Index local = 0, whole = 0, size = 0;
};

template <Backend B>
struct ProblemPart {
  std::unique_ptr<Problem<B>> problem;
  // Where its parameters lie in x, and the entries of its steps in a step of the whole: each entry once. Empty: it has
  // all of them, in the same order.
  std::vector<PartSegment> parameters, tangent;
};

// The cost is the sum of the parts' costs. A process makes the parts alone that fall to it.
template <Backend B>
class ProblemParts {
 public:
  virtual ~ProblemParts() = default;

  // Does not depend on how many processes there are: the order of sums goes by it. 64 suit most problems.
  virtual int num_parts() const = 0;
  virtual ProblemPart<B> Make(int part) = 0;
  virtual Index num_parameters() const = 0;
  virtual Index num_tangent() const { return num_parameters(); }
  // Of the whole; empty: none. A part's blocks are blocks of these.
  virtual std::vector<BlockGroup> block_groups() const { return {}; }
  // What of the whole is no sum: how steps are made, bounds, the metric, names. Null: the defaults of
  // solver/problem_interfaces.h. Its costs and linearizations are not asked for. The same at every call. Must outlive
  // the distributed problem.
  virtual Problem<B>* geometry() { return nullptr; }
  // Whether the parts' last parameters are a block-diagonal group that no two parts share, and all before them are the
  // same of all parts, the first of the whole: then the group is eliminated part by part
  // (WithReducedSystem of the parts).
  virtual bool eliminates() const { return false; }
};

}  // namespace vesta
