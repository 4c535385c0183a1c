#include "apps/cli/process.h"

#include <chrono>

namespace vesta::app {

double SecondsSinceStart() {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point start = Clock::now();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace vesta::app
