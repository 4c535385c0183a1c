// Parallel loops on plain std::thread: the driver under which the thread sanitizer sees every access. (Debian's oneTBB
// is not instrumented, and the sanitizer would report false races.)
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"

namespace vesta {
namespace {

int g_num_threads = 0;
thread_local bool t_inside = false;  // nested loops run on the thread they are called from

}  // namespace

void SetNumThreads(int num_threads) {
  CheckNumThreads(num_threads);
  g_num_threads = num_threads;
}

int NumThreads() {
  return g_num_threads > 0 ? g_num_threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void ParallelForChunks(Index count, Index grain, const std::function<void(Index, Index)>& body) {
  if (count <= 0) return;
  const Index chunks = (count + grain - 1) / grain;
  const int helpers = t_inside ? 0 : static_cast<int>(std::min<Index>(NumThreads(), chunks)) - 1;
  std::atomic<Index> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    const bool outer = std::exchange(t_inside, true);
    try {
      // Relaxed: stronger ordering would hide races between chunks from the sanitizer.
      const auto claim = [&] { return next.fetch_add(1, std::memory_order_relaxed); };
      for (Index c = claim(); c < chunks; c = claim()) body(c * grain, std::min(count, (c + 1) * grain));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      next.store(chunks, std::memory_order_relaxed);
    }
    t_inside = outer;
  };
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(helpers));
  for (int i = 0; i < helpers; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace vesta
