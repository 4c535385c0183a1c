// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/huge_pages.h"

#include <cstdint>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace vesta {

void AdviseHugePages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef MADV_HUGEPAGE
  if (bytes < kLeastForHugePages) return;
  // Whole pages only.
  constexpr std::uintptr_t kPage = 65536;  // at least the page size of all common systems
  auto* const first = static_cast<std::byte*>(memory);
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t begin = (address + kPage - 1) / kPage * kPage, end = (address + bytes) / kPage * kPage;
  madvise(first + (begin - address), end - begin, MADV_HUGEPAGE);
#endif
}

}  // namespace vesta
