// Rows of what is laid out as a model (kernels/gaussian_splatting/layout.h), for when Gaussians change places.
#pragma once

#include <cstdint>

#include "kernels/core/divisor.h"
#include "kernels/core/for_each.h"
#include "kernels/core/hd.h"

namespace vesta::gs {

// to = the rows `source` of `from`: structures of arrays with `attributes` columns of so many rows, all pointers to one
// memory space. Zero where a row is not kept; kept null: all are.
template <class Row>
struct RowGathering {
  Index attributes, from_rows, to_rows;
  const Row* source;
  const std::uint8_t* kept;
  const float* from;
  float* to;
  Divisor by_rows{to_rows};

  VESTA_HD void operator()(Index entry) const {
    const auto [attribute, row] = by_rows.Divide(entry);
    to[entry] = !kept || kept[row] != 0 ? from[attribute * from_rows + source[row]] : 0.0f;
  }
};

template <class Space, class Row>
void GatherRows(const RowGathering<Row>& gathering) {
  ForEach<Space>(gathering.attributes * gathering.to_rows, 65536, gathering);
}

}  // namespace vesta::gs
