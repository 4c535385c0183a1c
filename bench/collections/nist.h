// SPDX-License-Identifier: Apache-2.0
// The NIST regressions (bench/collections/nist_data.h) as a table of SmallProblem.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bench/collections/nist_data.h"
#include "bench/collections/small_problem.h"

namespace vesta::nist {

struct Regression {
  const Problem& data;
  SmallProblem problem;
  std::function<std::unique_ptr<vesta::Problem<CpuBackend<float>>>()> make_in_float;
};

// All 27, in the order of ForEachProblem (bench/collections/nist_models.h).
const std::vector<Regression>& Regressions();

}  // namespace vesta::nist
