// SPDX-License-Identifier: Apache-2.0
// Counts memory as it is allocated. Linking it replaces operator new and delete, so such tests are separate programs.
// Not for sanitizers, which replace the allocator themselves.
#pragma once

namespace vesta::test {

// Counts from its construction. Only one may exist at a time.
class CountedMemory {
 public:
  CountedMemory();
  // The peak of additional memory since construction, bytes.
  double peak_bytes() const;

 private:
  long before_;
};

}  // namespace vesta::test
