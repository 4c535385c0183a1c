// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/problem.h and solver/problem_interfaces.h.
#pragma once

#include "kernels/core/check.h"
#include "solver/problem_interfaces.h"

namespace vesta {

template <Backend B>
void Problem<B>::CheckSize(ConstVectorView x) const {
  if (x.size() != num_parameters()) {
    Fail(kBadArgument, "x has {} entries, but the problem has {} parameters; give x one entry per parameter", x.size(),
         num_parameters());
  }
}

template <Backend B>
void InUnits<B>::CheckUnits(std::span<const Index> units) const {
  for (const Index unit : units) {
    if (unit < 0 || unit >= num_units())
      Fail(kBadArgument, "there is no unit {}; the problem has {}, counted from 0", unit, num_units());
  }
}

template <Backend B>
void InBatches<B>::CheckBatch(int batch) const {
  if (batch < 0 || batch >= num_batches())
    Fail(kBadArgument, "there is no batch {}; the problem has {}, counted from 0", batch, num_batches());
}

template <Backend B>
std::unique_ptr<Linearization<B>> InBatches<B>::LinearizeOnlyBatch(typename B::ConstVectorView x) {
  if (num_batches() != 1)
    Fail(kUnsupported, "a problem with {} batches must be linearized by LinearizeBatch", num_batches());
  return LinearizeBatch(x, 0);
}

}  // namespace vesta
