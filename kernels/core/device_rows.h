// SPDX-License-Identifier: Apache-2.0
// The launches of row_blocks.h on a GPU. All pointers are to the GPU's memory. No function waits.
#pragma once

#include "kernels/core/row_blocks.h"

namespace vesta::device {

template <class S>
void ApplyRows(const RowBlocks<S>& rows, const S* v, S* u);
// u null: diag(J^T J). partial: one for each segment.
template <class S>
void ApplyRowsTransposed(const RowBlocks<S>& rows, const RowBlocksTranspose& transpose, Index segments,
                         Index parameters, const S* u, S* partial, S* g);
template <class S>
void GramBlocks(const RowBlocks<S>& rows, const RowBlocksTranspose& transpose, const BlockGroup& group, S* values);

}  // namespace vesta::device
