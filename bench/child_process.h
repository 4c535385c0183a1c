// SPDX-License-Identifier: Apache-2.0
// Runs a function in a child process, unaffected by earlier work, and measures its peak memory.
#pragma once

#include <functional>
#include <string>

namespace vesta::bench {

struct ChildResult {
  std::string bytes;    // everything that `work` sent
  double peak_mib = 0;  // peak resident memory, including pages inherited from the parent
  bool failed = true;   // `work` threw, or a signal ended the child
};

// For `work`: sends bytes to the parent. Throws Error if that fails.
using Send = std::function<void(const void* data, std::size_t bytes)>;

// Waits until `work` ends in a child process. If it throws, prints `name` and the message on stderr. The calling
// process must not have started threads, which do not exist in the child. Throws Error if no process can be created.
ChildResult RunInChild(const std::string& name, const std::function<void(const Send&)>& work);

}  // namespace vesta::bench
