// SPDX-License-Identifier: Apache-2.0
// One call that looks for mistakes in a problem, and says in words what is wrong: for its test, and where a solve does
// not get anywhere.
#pragma once

#include <string>
#include <vector>

#include "solver/problem.h"

namespace vesta {

struct CheckProblemOptions {
  // Columns of J that are looked at one by one, spread evenly; >= 1. All, where there are no more.
  Index max_columns = 100;
  // Relative error of what agrees but for rounding (adjointness, products, diagonal, blocks); 0: 1e-8 for double, 1e-3
  // for float.
  double rounding = 0;
  // Relative error of derivatives beside differences, which have one of their own that is estimated; 0: 1e-5 for
  // double, 1e-2 for float.
  double derivatives = 0;
  // false: DiagJTJ and BlockGram are stand-ins for those of J^T W J (documented as such), and not compared with them.
  bool exact_blocks = true;
};

struct ProblemCheck {
  std::vector<std::string> faults;  // a line each, the deepest first; empty: none was found
  bool ok() const { return faults.empty(); }
  // All of them, or that there are none.
  std::string Report() const;
};

// Calls everything that a solve calls, at x and close to it: whether Plus and every product write all they should,
// and finite numbers; Cost gives the same twice; ApplyJ and ApplyJT are adjoint; ApplyW is symmetric and not negative;
// ApplyH, Curvature, Gradient, DiagJTJ and BlockGram are those of J and W; J is the derivative of the residuals along
// Plus (where there are no weights and no loss), and Gradient of Cost. Takes some 100 evaluations of each, and a
// product with each column that is looked at. At kinks of the residuals nothing can be told of the derivatives. A
// problem that samples (InBatches::OnNewPoint) has a gradient that is not the cost's, and is told so. Mistakes that a
// solve throws as Error are faults here too.
template <Backend B>
ProblemCheck CheckProblem(B& backend, Problem<B>& problem, typename B::ConstVectorView x,
                          const CheckProblemOptions& options = {});

}  // namespace vesta
