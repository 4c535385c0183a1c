#include "problems/gaussian_splatting/model/gather_rows.h"

#include "kernels/core/parallel.h"

namespace vesta::gs {

std::vector<float> GatherRows(const std::vector<float>& data, Index count, int attributes,
                              const std::vector<Index>& source) {
  const auto rows = static_cast<Index>(source.size());
  std::vector<float> result(static_cast<std::size_t>(rows * attributes));
  ParallelFor(attributes, 1, [&](Index a) {
    const float* from = data.data() + a * count;
    float* to = result.data() + a * rows;
    for (Index i = 0; i < rows; ++i) to[i] = from[source[static_cast<std::size_t>(i)]];
  });
  return result;
}

}  // namespace vesta::gs
