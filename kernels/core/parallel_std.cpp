// SPDX-License-Identifier: Apache-2.0
// Parallel loops on std::thread, for the thread sanitizer. (Debian's oneTBB is not instrumented, so the sanitizer would
// report false races.)
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"

namespace vesta {
namespace {

int g_num_threads = 0;
thread_local bool t_inside = false;  // nested loops run on the thread they are called from

// A worker thread that serves one caller, loop after loop: under the sanitizer, starting a thread takes longer than
// most loops. Each worker has its own lock: a shared one would order the work of two workers and hide their races from
// the sanitizer.
class Helper {
 public:
  Helper() : thread_([this] { Run(); }) {}
  ~Helper() {
    Set(nullptr, true);
    thread_.join();
  }
  Helper(const Helper&) = delete;
  Helper& operator=(const Helper&) = delete;

  // `work` must not throw, and must outlive Wait.
  void Start(const std::function<void()>& work) { Set(&work, false); }
  void Wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !work_; });
  }

 private:
  void Set(const std::function<void()>* work, bool ends) {
    {
      const std::lock_guard lock(mutex_);
      work_ = work, ends_ = ends;
    }
    changed_.notify_one();
  }
  const std::function<void()>* Next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return work_ || ends_; });
    return work_;
  }
  void Run() {
    t_inside = true;
    while (const std::function<void()>* work = Next()) {
      (*work)();
      Set(nullptr, false);
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* work_ = nullptr;
  bool ends_ = false;
  std::thread thread_;  // declared last because it uses the other members
};

// Returns `count` worker threads of the calling thread.
std::span<const std::unique_ptr<Helper>> Helpers(std::size_t count) {
  thread_local std::vector<std::unique_ptr<Helper>> helpers;
  while (helpers.size() < count) helpers.push_back(std::make_unique<Helper>());
  return std::span(helpers).first(count);
}

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
  const auto helpers = Helpers(t_inside ? 0 : static_cast<std::size_t>(std::min<Index>(NumThreads(), chunks)) - 1);
  std::atomic<Index> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const std::function<void()> work = [&] {
    const bool outer = std::exchange(t_inside, true);
    try {
      // Relaxed: stronger ordering would hide races between chunks.
      const auto claim = [&] { return next.fetch_add(1, std::memory_order_relaxed); };
      for (Index c = claim(); c < chunks; c = claim()) body(c * grain, std::min(count, (c + 1) * grain));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      next.store(chunks, std::memory_order_relaxed);
    }
    t_inside = outer;
  };
  for (const auto& helper : helpers) helper->Start(work);
  work();
  for (const auto& helper : helpers) helper->Wait();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace vesta
