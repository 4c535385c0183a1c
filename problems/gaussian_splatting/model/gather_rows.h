// SPDX-License-Identifier: Apache-2.0
// Copies selected Gaussians, to reorder, add or remove them. In a model (kernels/gaussian_splatting/formulas/layout.h)
// a Gaussian is a row, an attribute a column.
#pragma once

#include <cstdint>

#include "kernels/core/buffer.h"
#include "kernels/core/divisor.h"
#include "kernels/core/for_each.h"
#include "kernels/core/hd.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Copies row source[i] of `from` to row i of `to`, for i < to_rows. `from` has from_rows rows; both have `attributes`
// columns, one after the other. Row i of `to` becomes zero if kept[i] is 0, or if source[i] >= from_rows. kept: one
// byte per row of `to`; null: all 1. All pointers are in one memory space.
template <class Row, class T = float>
struct RowGathering {
  Index attributes, from_rows, to_rows;
  const Row* source;
  const std::uint8_t* kept;
  const T* from;
  T* to;
  Divisor by_rows{to_rows};

  VESTA_HD void operator()(Index entry) const {
    const auto [attribute, row] = by_rows.Divide(entry);
    const auto from_row = static_cast<Index>(source[row]);
    const bool is_there = from_row < from_rows && (!kept || kept[row] != 0);
    to[entry] = is_there ? from[attribute * from_rows + from_row] : T(0);
  }
};

using NumberGathering = RowGathering<std::uint32_t, int>;

template <class Space, class Row, class T>
void GatherRows(const RowGathering<Row, T>& gathering) {
  ForEach<Space>(gathering.attributes * gathering.to_rows, 65536, gathering);
}

// Returns one number per Gaussian: from[source[k]], or zero if source[k] is out of range.
template <class T, class Space>
Buffer<T, Space> GatherNumbers(const Buffer<T, Space>& from, const Buffer<std::uint32_t, Space>& source) {
  Buffer<T, Space> to;
  to.ResizeForOverwrite(source.size());
  GatherRows<Space>(
      RowGathering<std::uint32_t, T>{1, from.size(), to.size(), source.data(), nullptr, from.data(), to.data()});
  return to;
}

// Arrays have the layout of layout.h. Gaussian k of `to` becomes Gaussian source[k] of `from`, or zero if kept[k] is 0
// (kept null: all are copied). A spherical-harmonics band of a Gaussian becomes zero if `from` lacks the band, and is
// dropped if `to` lacks it.
template <class Space, class Row>
void GatherGaussians(const splat::ModelLayout& from_layout, const splat::ModelLayout& to_layout, const Row* source,
                     const std::uint8_t* kept, const float* from, float* to) {
  for (int band = 0; band <= to_layout.sh_degree; ++band) {
    const int first = splat::FirstOfBand(band), attributes = splat::NumAttributes(band) - first;
    GatherRows<Space>(RowGathering<Row>{attributes, from_layout.WithBand(band), to_layout.WithBand(band), source, kept,
                                        from + from_layout.Offset(first), to + to_layout.Offset(first)});
  }
}

}  // namespace vesta::gs
