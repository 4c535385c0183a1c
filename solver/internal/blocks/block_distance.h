// SPDX-License-Identifier: Apache-2.0
// How far apart the blocks of a problem are.
#pragma once

#include "solver/internal/blocks/block_structure.h"

namespace vesta {

// The longest way between two kept blocks, in hops: from a block to those that it shares a residual block with, or an
// eliminated block. An error crosses one hop in an iteration of conjugate gradients on what is kept. Found by two
// searches through each part that hangs together, so it is a lower bound (exact for trees), at the cost of a pass over
// the cells.
int LongestDistance(const BlockStructure& structure);

}  // namespace vesta
