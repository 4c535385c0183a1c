// Rows of what is laid out as a model (kernels/gaussian_splatting/layout.h), for when Gaussians change places.
#pragma once

#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

// The rows `source` of a structure of arrays with `count` rows and `attributes` columns.
std::vector<float> GatherRows(const std::vector<float>& data, Index count, int attributes,
                              const std::vector<Index>& source);

}  // namespace vesta::gs
