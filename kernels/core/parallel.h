// SPDX-License-Identifier: Apache-2.0
// The only door to threads. Results never depend on the number of threads: loops write disjoint data, and
// reductions add partial sums of fixed chunks in a fixed order.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/error.h"
#include "kernels/core/span.h"

namespace vesta {

// Number of threads used by all parallel loops, the caller's included; 0 means one for each core. Throws Error where it
// is negative.
void SetNumThreads(int num_threads);
int NumThreads();
// What SetNumThreads checks.
inline void CheckNumThreads(int num_threads) {
  if (num_threads < 0)
    throw Error(kBadArgument, "num_threads is " + std::to_string(num_threads) + "; choose 0 for all cores, or more");
}

// Calls body(begin, end) for consecutive chunks of `grain` indices that cover [0, count), on all threads, in any
// order. Chunk boundaries are multiples of grain whatever the number of threads. An exception of the body's is
// rethrown in the caller. May be nested (inner loops then run on whatever threads are free).
void ParallelForChunks(Index count, Index grain, const std::function<void(Index begin, Index end)>& body);

// Calls body(i) for each i in [0, count); grain indices make one task.
template <class Body>
void ParallelFor(Index count, Index grain, const Body& body) {
  ParallelForChunks(count, grain, [&body](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) body(i);
  });
}

// Sum over chunks of body(begin, end), partial sums added in the order of the chunks.
template <class T, class Body>
T ParallelSum(Index count, Index grain, const Body& body) {
  const Index chunks = (count + grain - 1) / grain;
  std::vector<T> partial(static_cast<std::size_t>(std::max<Index>(chunks, 0)));
  ParallelForChunks(count, grain, [&](Index begin, Index end) {
    partial[static_cast<std::size_t>(begin / grain)] = body(begin, end);
  });
  T sum{};
  for (const T& value : partial) sum += value;
  return sum;
}

// Work beside the program.
//
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
