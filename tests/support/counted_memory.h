// SPDX-License-Identifier: Apache-2.0
// Measures the peak of allocated memory. Replaces operator new and delete, so such a test is its own program. Not for
// sanitizers, which replace the allocator.
#pragma once

namespace vesta::test {

// Only one object may exist at a time.
class CountedMemory {
 public:
  CountedMemory();
  // Peak since construction minus the memory then allocated, bytes.
  double peak_bytes() const;

 private:
  long before_;
};

}  // namespace vesta::test
