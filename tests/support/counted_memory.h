// SPDX-License-Identifier: Apache-2.0
// Measures the peak of allocated memory. A test that uses it replaces operator new and delete and is therefore a
// program of its own. Not for sanitizers, which replace the allocator themselves.
#pragma once

namespace vesta::test {

// Measures from its construction on. Only one object may exist at a time.
class CountedMemory {
 public:
  CountedMemory();
  // The peak of the allocated memory since construction minus the memory allocated at construction, bytes.
  double peak_bytes() const;

 private:
  long before_;
};

}  // namespace vesta::test
