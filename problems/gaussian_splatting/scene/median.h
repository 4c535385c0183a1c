// The median.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vesta::gs {

// The upper one of an even number. There must be one.
template <class T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace vesta::gs
