// SPDX-License-Identifier: Apache-2.0
// Runs work in a child process, so that earlier work cannot affect it and its peak memory is measured separately.
#pragma once

#include <functional>
#include <string>

namespace vesta::bench {

struct ChildResult {
  std::string bytes;    // everything the work sent
  double peak_mib = 0;  // peak resident memory of the child, including pages inherited from the parent
  bool failed = true;   // the work threw (the name and message are on stderr), or the child died
};

// Sends bytes to the parent. Throws Error if that fails.
using Send = std::function<void(const void* data, std::size_t bytes)>;

// Runs work in a child process and waits for it. The parent must not have started threads before.
// Throws Error if no process can be created.
ChildResult RunInChild(const std::string& name, const std::function<void(const Send&)>& work);

}  // namespace vesta::bench
