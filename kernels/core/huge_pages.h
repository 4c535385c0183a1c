// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace vesta {

// Asks the system for large pages for memory that is about to be used, since the first access to each page costs
// microseconds. No effect below kLeastForHugePages bytes, or if the system does not have them.
inline constexpr std::size_t kLeastForHugePages = std::size_t{4} << 20;
void AdviseHugePages(void* memory, std::size_t bytes) noexcept;

}  // namespace vesta
