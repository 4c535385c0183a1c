// SPDX-License-Identifier: Apache-2.0
// Linearizes one batch of a problem at x and checks its sizes, as the engine does. The result has all interfaces of
// solver/problem_interfaces.h, with the engine's defaults where needed.
#pragma once

#include <memory>

#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

template <Backend B>
std::unique_ptr<LinearizationAdaptor<B>> LinearizeAt(Problem<B>& problem, typename B::ConstVectorView x,
                                                     int batch = 0) {
  return ProblemAdaptor<B>(problem).CheckedLinearize(x, batch);
}

}  // namespace vesta
