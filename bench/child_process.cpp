// SPDX-License-Identifier: Apache-2.0
#include "bench/child_process.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <exception>

#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

void WriteAll(int file, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = write(file, at, bytes);
    if (written <= 0) Fail(kUnavailable, "cannot write to the parent process");
    at += written;
    bytes -= static_cast<std::size_t>(written);
  }
}

[[noreturn]] void Child(const std::string& name, const std::function<void(const Send&)>& work, int out) {
  int status = 1;
  try {
    work([out](const void* data, std::size_t bytes) { WriteAll(out, data, bytes); });
    status = 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
  }
  close(out);
  // Without destructors: worker threads may still wait.
  _exit(status);
}

}  // namespace

ChildResult RunInChild(const std::string& name, const std::function<void(const Send&)>& work) {
  int ends[2];
  if (pipe(ends) != 0) Fail(kUnavailable, "cannot create a pipe for a child process");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) Fail(kUnavailable, "cannot create a child process");
  if (child == 0) {
    close(ends[0]);
    Child(name, work, ends[1]);
  }
  close(ends[1]);
  ChildResult result;
  std::array<char, 65536> some;
  for (ssize_t got = 0; (got = read(ends[0], some.data(), some.size())) > 0;) {
    result.bytes.append(some.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  result.failed = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
  result.peak_mib = static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts in KiB
  return result;
}

}  // namespace vesta::bench
