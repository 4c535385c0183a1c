// SPDX-License-Identifier: Apache-2.0
// Work beside the program: the other door to threads (parallel.h has the loops).
#pragma once

#include <functional>
#include <memory>

namespace vesta {

// A thread that runs one task after the other, in the order they came. It starts with the first.
class Background {
 public:
  Background();
  // Waits for the task that runs; those that wait for their turn are dropped.
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  // task must not throw.
  void Run(std::function<void()> task);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vesta
