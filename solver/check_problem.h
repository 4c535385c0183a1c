// SPDX-License-Identifier: Apache-2.0
// CheckProblem finds mistakes in a problem, such as a wrong derivative, and describes each. Use it in the problem's
// test, and when a solve makes no progress. J is the Jacobian of the residuals, W the weights of the loss
// (solver/problem_interfaces.h).
#pragma once

#include <string>
#include <vector>

#include "solver/problem.h"

namespace vesta {

struct CheckProblemOptions {
  // Number of columns of J to check one by one, evenly spread; >= 1. If J has fewer columns, all are checked.
  Index max_columns = 100;
  // Allowed relative error of the tests that involve no finite differences (adjointness, products, diagonal, blocks). 0
  // means 1e-8 for double, 1e-3 for float.
  double rounding = 0;
  // Allowed relative error between derivatives and finite differences. The estimated error of the finite differences is
  // added to it. 0 means 1e-5 for double, 1e-2 for float.
  double derivatives = 0;
  // Set to false if DiagJTJ and BlockGram only approximate J^T W J. Then they are not compared with J^T W J. The
  // documentation of the problem should state this approximation.
  bool exact_blocks = true;
};

struct ProblemCheck {
  std::vector<std::string> faults;  // one line per fault, causes before effects; empty if the problem passed
  bool ok() const { return faults.empty(); }
  // All faults, one per line. If the problem passed, one line that says so.
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
// gradient check, because the gradient belongs to the sample, but the cost to all residuals. Mistakes that make a solve
// throw Error are listed as faults here.
template <Backend B>
ProblemCheck CheckProblem(B& backend, Problem<B>& problem, typename B::ConstVectorView x,
                          const CheckProblemOptions& options = {});

}  // namespace vesta
