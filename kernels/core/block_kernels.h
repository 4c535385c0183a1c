// SPDX-License-Identifier: Apache-2.0
// The device code of block-diagonal matrices (block_diagonal.h). Each thread works on one block; neighbouring threads
// read neighbouring values. Declared for host code, defined in block_kernels.cu.
#pragma once

#include "kernels/core/block_diagonal.h"

namespace vesta::device {

// Largest order of a block: a thread keeps its block in memory of its own.
inline constexpr int kMaxBlockOrder = 32;

// values: NumValues() of one group. treated: [1], added to.
template <class S>
void AddToBlockDiagonal(const BlockGroup& group, double scale, const S* d, S* values);
template <class S>
void BlockDiagonalOf(const BlockGroup& group, const S* values, S* out);
template <class S>
void MultiplyBlocks(const BlockGroup& group, const S* values, const S* x, S* y);
template <class S>
void FactorizeBlocks(const BlockGroup& group, S* values, unsigned long long* treated);
template <class S>
void SolveBlocks(const BlockGroup& group, const S* values, const S* x, S* y);

}  // namespace vesta::device
