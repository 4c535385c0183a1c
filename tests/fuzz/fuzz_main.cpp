// SPDX-License-Identifier: Apache-2.0
// The libFuzzer entry point of the target VESTA_FUZZ_TARGET.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  vesta::fuzz::VESTA_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
