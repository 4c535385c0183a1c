// SPDX-License-Identifier: Apache-2.0
// Symbolic derivatives of a program.
#pragma once

#include <vector>

#include "problems/program/program.h"

namespace vesta::program {

// An entry of the Jacobian that may differ from 0.
struct JacobianEntry {
  int output, variable;
};

struct Derivatives {
  // Outputs: those of the original program, then one per entry.
  Program program;
  std::vector<JacobianEntry> entries;  // ordered by output, then variable
};

// Differentiates the outputs with respect to the inputs 0, ..., num_variables - 1. Uses forward or reverse
// accumulation, whichever needs fewer operations (Griewank and Walther, Evaluating Derivatives, 2008, chapter 3).
// Programs with kSelect use forward accumulation, so that a NaN derivative of the value that is not selected has no
// influence. At a point without a derivative, such as kAbs at 0, the result is one of its one-sided derivatives.
Derivatives Differentiate(const Program& program, int num_variables);

}  // namespace vesta::program
