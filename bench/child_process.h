// SPDX-License-Identifier: Apache-2.0
// Runs a function in a child process, so that earlier work does not affect it and its peak memory is measured
// separately.
#pragma once

#include <functional>
#include <string>

namespace vesta::bench {

struct ChildResult {
  std::string bytes;    // all bytes that `work` sent
  double peak_mib = 0;  // peak resident memory of the child, including pages inherited from the parent
  bool failed = true;   // true if `work` threw, or if a signal ended the child
};

// For `work`: sends bytes to the parent process. Throws Error if that fails.
using Send = std::function<void(const void* data, std::size_t bytes)>;

// Calls `work` in a child process and waits for its end. If `work` throws, prints `name` and the message on stderr. The
// calling process must not have started threads before, because they do not exist in the child. Throws Error if no
// process can be created.
ChildResult RunInChild(const std::string& name, const std::function<void(const Send&)>& work);

}  // namespace vesta::bench
