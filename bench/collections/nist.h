// NIST's regressions (problems/toy/nist.h) as problems.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bench/collections/small_problem.h"
#include "problems/toy/nist.h"

namespace vesta::nist {

struct Regression {
  const Problem& data;
  SmallProblem problem;
  std::function<std::unique_ptr<vesta::Problem<CpuBackend<float>>>()> make_in_float;
};

// All 27, in the order of ForEachProblem (problems/toy/nist_models.h).
const std::vector<Regression>& Regressions();

}  // namespace vesta::nist
