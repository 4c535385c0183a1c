// SPDX-License-Identifier: Apache-2.0
// Symmetric matrices as packed lower triangles, row by row.
#pragma once

#include "kernels/core/hd.h"

namespace vesta {

// Index of element (row, col), row >= col, in the packed array.
VESTA_HD constexpr int PackedLower(int row, int col) { return row * (row + 1) / 2 + col; }
// Number of elements.
VESTA_HD constexpr int PackedSize(int order) { return PackedLower(order, 0); }

}  // namespace vesta
