// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/process_memory.h"

#include <sys/resource.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace vesta {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

// Returns the number at the start of a file, or `otherwise` for text such as "max".
double NumberIn(const char* path, double otherwise) {
  std::ifstream file(path);
  double number = otherwise;
  return file >> number ? number : otherwise;
}

// Returns the number after `name` in a file with one name and number per line.
double NumberNamed(const std::string& name, const char* path, double otherwise) {
  std::ifstream file(path);
  std::string word, rest;
  for (double number = 0; file >> word >> number; std::getline(file, rest)) {
    if (word == name) return number;
  }
  return otherwise;
}

}  // namespace

void ReturnFreedMemoryToSystem() {
#ifdef __GLIBC__
  // Setting a threshold stops glibc from raising both of them by itself. Without the second one, it would return the
  // end of the heap, from 128 KiB, at each deallocation, and the system would clear these pages again at the next use.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_TRIM_THRESHOLD, 16 << 20);
#endif
}

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux counts in KiB
}

double MemoryMib() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0, resident = 0;
  statm >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

double AvailableMemoryMib() {
  // Without cached pages of files, which the kernel drops when needed.
  const double used =
      NumberIn("/sys/fs/cgroup/memory.current", 0) - NumberNamed("inactive_file", "/sys/fs/cgroup/memory.stat", 0);
  const double in_group = std::max(0.0, NumberIn("/sys/fs/cgroup/memory.max", kUnknown) - used);
  return std::min(NumberNamed("MemAvailable:", "/proc/meminfo", kUnknown) / 1024, in_group / (1 << 20));
}

}  // namespace vesta
