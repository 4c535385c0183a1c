// SPDX-License-Identifier: Apache-2.0
// CheckProblem finds mistakes in a problem and describes each in words. Use it in the problem's test, and when a solve
// makes no progress.
#pragma once

#include <string>
#include <vector>

#include "solver/problem.h"

namespace vesta {

struct CheckProblemOptions {
  // Number of columns of J to check one by one, evenly spread; >= 1. All columns if J has no more.
  Index max_columns = 100;
  // Allowed relative error between values that differ only by rounding (adjointness, products, diagonal, blocks). 0
  // means 1e-8 for double, 1e-3 for float.
  double rounding = 0;
  // Allowed relative error between derivatives and finite differences, in addition to the estimated error of the
  // differences. 0 means 1e-5 for double, 1e-2 for float.
  double derivatives = 0;
  // False if DiagJTJ and BlockGram only approximate J^T W J, as documented. They are then not compared.
  bool exact_blocks = true;
};

struct ProblemCheck {
  std::vector<std::string> faults;  // one line per fault, causes before effects; empty without faults
  bool ok() const { return faults.empty(); }
  // All faults, one per line; one line without a fault if the problem passed.
  std::string Report() const;
};

// Calls every function that a solve calls, at x (num_parameters() entries) and near it. It checks the following:
//   * Plus and all products write every entry, with finite numbers.
//   * Cost gives the same value twice.
//   * ApplyJ and ApplyJT are adjoint. ApplyW is symmetric and positive semidefinite.
//   * ApplyH, Curvature, Gradient, DiagJTJ and BlockGram agree with J and W.
//   * J is the derivative of the residuals along Plus (only without weights and losses).
//   * Gradient is the derivative of Cost.
// This takes about 100 evaluations of each function, and one product per checked column. Derivatives at kinks of the
// residuals cannot be checked. A problem that uses a random sample of its residuals (InBatches::OnNewPoint) fails the
// gradient check, because it returns the gradient of the sample. Where a solve would throw Error, the result lists a
// fault.
template <Backend B>
ProblemCheck CheckProblem(B& backend, Problem<B>& problem, typename B::ConstVectorView x,
                          const CheckProblemOptions& options = {});

}  // namespace vesta
