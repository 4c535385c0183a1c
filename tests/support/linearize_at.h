// SPDX-License-Identifier: Apache-2.0
// Computes the linearization of a problem with everything that the engine may request.
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
