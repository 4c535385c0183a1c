// SPDX-License-Identifier: Apache-2.0
// Parallel loops on oneTBB. (parallel_std.cpp: the same for the thread sanitizer.)
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <memory>

#include "kernels/core/parallel.h"

namespace vesta {
namespace {

std::unique_ptr<tbb::global_control> g_control;
int g_num_threads = 0;

}  // namespace

void SetNumThreads(int num_threads) {
  CheckNumThreads(num_threads);
  g_num_threads = num_threads;
  g_control.reset();
  // A single thread does not need oneTBB, which at its start searches for its allocator and queries the memory.
  if (num_threads > 1) {
    g_control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      static_cast<std::size_t>(num_threads));
  }
}

int NumThreads() { return g_num_threads > 0 ? g_num_threads : tbb::info::default_concurrency(); }

void ParallelForChunks(Index count, Index grain, const std::function<void(Index, Index)>& body) {
  if (count <= 0) return;
  const Index chunks = (count + grain - 1) / grain;
  const auto run = [&](Index begin, Index end) {
    for (Index c = begin; c < end; ++c) body(c * grain, std::min(count, (c + 1) * grain));
  };
  if (chunks == 1 || g_num_threads == 1) return run(0, chunks);
  tbb::parallel_for(
      tbb::blocked_range<Index>(0, chunks, 1),
      [&](const tbb::blocked_range<Index>& range) { run(range.begin(), range.end()); }, tbb::simple_partitioner());
}

}  // namespace vesta
