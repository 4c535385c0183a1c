// SPDX-License-Identifier: Apache-2.0
// Parallel loops; all of the library's threads start here. Results do not depend on the number of threads: loops write
// disjoint data, and reductions add fixed chunks in a fixed order.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/error.h"
#include "kernels/core/span.h"

namespace vesta {

// Sets the number of threads, including the calling one; 0 means one per core. Throws Error if it is negative.
void SetNumThreads(int num_threads);
int NumThreads();
// The check that SetNumThreads makes.
inline void CheckNumThreads(int num_threads) {
  if (num_threads < 0)
    throw Error(kBadArgument, "num_threads is " + std::to_string(num_threads) + "; choose 0 for all cores, or more");
}

// Divides [0, count) into consecutive chunks of `grain` indices. Calls body(begin, end) for them on all threads, in any
// order. Chunk boundaries are multiples of grain for any number of threads. Exceptions of body are rethrown. body may
// call this function.
void ParallelForChunks(Index count, Index grain, const std::function<void(Index begin, Index end)>& body);

// Calls body(i) for each i in [0, count), with `grain` indices per task.
template <class Body>
void ParallelFor(Index count, Index grain, const Body& body) {
  ParallelForChunks(count, grain, [&body](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) body(i);
  });
}

// Returns the sum of body(begin, end) over all chunks of `grain` indices, in the order of the chunks. T{} must be zero.
template <class T, class Body>
T ParallelSum(Index count, Index grain, const Body& body) {
  T sum{};
  if (count <= grain) {
    if (count > 0) sum += body(0, count);
    return sum;
  }
  std::vector<T> partial(static_cast<std::size_t>((count + grain - 1) / grain));
  ParallelForChunks(count, grain, [&](Index begin, Index end) {
    partial[static_cast<std::size_t>(begin / grain)] = body(begin, end);
  });
  for (const T& value : partial) sum += value;
  return sum;
}

// For ParallelSum: += keeps the larger value, or NaN if either value is NaN.
struct Largest {
  double value = 0;
  Largest& operator+=(const Largest& other) {
    if (std::isnan(other.value) || other.value > value) value = other.value;
    return *this;
  }
};

// A background thread that runs tasks in the order of the calls. It starts with the first task.
class Background {
 public:
  Background();
  // Waits for the running task and drops the others.
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
