// SPDX-License-Identifier: Apache-2.0
// Memory counted as it is allocated. Who links this has operator new and delete replaced: a program of its own, and not
// for the sanitizers, which allocate in a way of their own.
#pragma once

namespace vesta::test {

// Counts from its construction on; one at a time.
class CountedMemory {
 public:
  CountedMemory();
  // The most that has been held beyond what was there before.
  double peak_bytes() const;

 private:
  long before_;
};

}  // namespace vesta::test
