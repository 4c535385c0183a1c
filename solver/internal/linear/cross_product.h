// SPDX-License-Identifier: Apache-2.0
// The innermost loop that forms normal equations and Schur complements, compiled once per instruction set.
#pragma once

#include "kernels/core/cpu_dispatch.h"

namespace vesta {

// A matrix with row-major values; row i begins at values + i * stride.
struct StridedMatrix {
  const double* values;
  int stride, cols;
};

// W += sign A^T B. A and B have `rows` rows; W is row-major without gaps.
using AddCrossProduct = void(const StridedMatrix& a, const StridedMatrix& b, int rows, double sign, double* w);

// The function for an instruction set that the CPU supports. All of them give the same bits.
AddCrossProduct* AddCrossProductFor(Isa isa);

}  // namespace vesta
