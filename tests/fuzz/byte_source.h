// SPDX-License-Identifier: Apache-2.0
// Numbers from the input bytes of a fuzz target; zeros when they are used up.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace vesta::fuzz {

class ByteSource {
 public:
  explicit ByteSource(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  T Take() {
    T value{};
    const std::size_t size = std::min(sizeof(T), rest_.size());
    if (size > 0) std::memcpy(&value, rest_.data(), size);
    rest_.remove_prefix(size);
    return value;
  }
  // A number from 0 to count - 1.
  int Below(int count) { return Take<std::uint8_t>() % count; }
  // A number from lo to hi, in 65536 steps.
  double Between(double lo, double hi) { return lo + (hi - lo) * Take<std::uint16_t>() / 65535.0; }

 private:
  std::string_view rest_;
};

}  // namespace vesta::fuzz
