// SPDX-License-Identifier: Apache-2.0
// Work in a process of its own: no contender is affected by an earlier one, and each has its own peak of memory.
#pragma once

#include <functional>
#include <string>

namespace vesta::bench {

struct ChildResult {
  std::string bytes;    // all that the work sent
  double peak_mib = 0;  // most resident memory of the child, what it took over from the parent included
  bool failed = true;   // it threw (its message is on stderr, after the name), or died
};

// Sends bytes to the parent. Throws Error where that fails.
using Send = std::function<void(const void* data, std::size_t bytes)>;

// Runs work in a child process and waits for it. The parent must not have started threads before.
// Throws Error where no process can be made.
ChildResult RunInChild(const std::string& name, const std::function<void(const Send&)>& work);

}  // namespace vesta::bench
