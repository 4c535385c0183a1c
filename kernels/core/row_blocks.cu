// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/launch.cuh"
#include "kernels/core/row_blocks.h"

namespace vesta::device {

template <class S>
void ApplyRows(const RowBlocks<S>& rows, const S* v, S* u) {
  ForEach(rows.blocks, MultiplyRows<S>{rows, v, u}, "J v");
}

template <class S>
void ApplyRowsTransposed(const RowBlocks<S>& rows, const RowBlocksTranspose& transpose, Index segments,
                         Index parameters, const S* u, S* partial, S* g) {
  ForEach(segments, SumSegment<S>{rows, transpose, u, partial}, "J^T u");
  ForEach(parameters, SumSegments<S>{transpose, partial, g}, "J^T u");
}

template <class S>
void GramBlocks(const RowBlocks<S>& rows, const RowBlocksTranspose& transpose, const BlockGroup& group, S* values) {
  ForEach(group.NumValues(), GramOfRows<S>{rows, transpose, group, values}, "blocks of J^T J");
}

#define VESTA_INSTANTIATE(S)                                                                                         \
  template void ApplyRows(const RowBlocks<S>&, const S*, S*);                                                        \
  template void ApplyRowsTransposed(const RowBlocks<S>&, const RowBlocksTranspose&, Index, Index, const S*, S*, S*); \
  template void GramBlocks(const RowBlocks<S>&, const RowBlocksTranspose&, const BlockGroup&, S*);
VESTA_INSTANTIATE(float)
VESTA_INSTANTIATE(double)
#undef VESTA_INSTANTIATE

}  // namespace vesta::device
