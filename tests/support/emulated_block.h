// SPDX-License-Identifier: Apache-2.0
// Runs the GPU kernels of kernels/core/block_kernel.h on the CPU. Each thread of a block is a fiber (fiber.h), which
// runs until its next barrier. The caller chooses the order of the threads. If a kernel lacks a barrier, results differ
// between two orders.
#pragma once

#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "kernels/core/block_kernel.h"
#include "tests/support/fiber.h"
#include "tests/support/random.h"

namespace vesta::test {

enum class ThreadOrder { kForward, kBackward, kShuffled };

// The threads of one block, reusable for many blocks.
class FiberBlock {
 public:
  FiberBlock(int threads, ThreadOrder order, std::uint64_t seed) : fibers_(static_cast<std::size_t>(threads)) {
    order_.resize(fibers_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    if (order == ThreadOrder::kBackward) std::reverse(order_.begin(), order_.end());
    if (order == ThreadOrder::kShuffled) {
      Random random(seed);
      for (std::size_t i = order_.size(); i > 1; --i) {
        std::swap(order_[i - 1], order_[static_cast<std::size_t>(random.Uniform(0, static_cast<double>(i)))]);
      }
    }
  }

  // Calls body(thread) once in every fiber. Throws std::logic_error if some threads wait at a barrier that others never
  // reach. Rethrows exceptions of the body.
  void Run(const std::function<void(int)>& body) {
    for (Fiber& fiber : fibers_) {
      if (!fiber.done) Prepare(fiber);  // new, or at a barrier because a body threw
      fiber.done = false;
    }
    body_ = &body;
    failure_ = nullptr;
    for (;;) {
      votes_ = next_votes_;
      next_votes_ = 0;
      std::size_t done = 0;
      for (const std::size_t t : order_) {
        current_ = t;
        if (!fibers_[t].done) SwitchFiber(scheduler_, fibers_[t].context);
        done += fibers_[t].done ? 1U : 0U;
        if (failure_) std::rethrow_exception(failure_);
      }
      if (done == fibers_.size()) return;
      if (done > 0) throw std::logic_error("a barrier that some threads of the block never reach");
    }
  }
  // A barrier. Returns the number of threads with vote = true.
  int Wait(bool vote) {
    next_votes_ += vote ? 1 : 0;
    Fiber& fiber = fibers_[current_];
    SwitchFiber(fiber.context, scheduler_);
    return votes_;
  }

 private:
  static constexpr std::size_t kStackBytes = 64 * 1024;
  struct Fiber {
    std::unique_ptr<char[]> stack;
    FiberContext context;
    bool done = false;
  };
  // Prepares the fiber to start at Enter.
  void Prepare(Fiber& fiber) {
    if (fiber.stack == nullptr) fiber.stack = std::make_unique_for_overwrite<char[]>(kStackBytes);
    PrepareFiber(fiber.context, fiber.stack.get(), kStackBytes, &FiberBlock::Enter,
                 reinterpret_cast<std::uintptr_t>(this));
  }
  // Runs in a fiber forever, one body after the other.
  static void Enter(std::uintptr_t block) {
    auto* self = reinterpret_cast<FiberBlock*>(block);
    const std::size_t thread = self->current_;
    for (;;) {
      try {
        (*self->body_)(static_cast<int>(thread));
      } catch (...) {
        self->failure_ = std::current_exception();
      }
      self->fibers_[thread].done = true;
      SwitchFiber(self->fibers_[thread].context, self->scheduler_);
    }
  }

  std::vector<Fiber> fibers_;
  std::vector<std::size_t> order_;
  FiberContext scheduler_;
  std::size_t current_ = 0;
  int votes_ = 0, next_votes_ = 0;
  const std::function<void(int)>* body_ = nullptr;
  std::exception_ptr failure_;
};

// The argument `block` of a kernel (block_kernel.h).
class EmulatedBlock {
 public:
  EmulatedBlock(FiberBlock& fibers, int thread, Index id) : fibers_(fibers), thread_(thread), id_(id) {}
  int thread() const { return thread_; }
  Index id() const { return id_; }
  void Sync() { fibers_.Wait(false); }
  int Count(bool value) { return fibers_.Wait(value); }

 private:
  FiberBlock& fibers_;
  int thread_;
  Index id_;
};

// Runs the blocks 0 .. blocks - 1 in order. Shared memory initially has all bits 1 (NaN), to reveal reads before
// writes.
template <class Kernel>
void Emulate(const Kernel& kernel, Index blocks, FiberBlock& fibers) {
  auto shared = std::make_unique<typename Kernel::Shared>();
  for (Index id = 0; id < blocks; ++id) {
    std::memset(static_cast<void*>(shared.get()), 0xff, sizeof(*shared));
    fibers.Run([&](int thread) {
      EmulatedBlock block(fibers, thread, id);
      kernel(block, *shared);
    });
  }
}
template <class Kernel>
void Emulate(const Kernel& kernel, Index blocks, ThreadOrder order = ThreadOrder::kForward) {
  FiberBlock fibers(Kernel::kThreads, order, 1);
  Emulate(kernel, blocks, fibers);
}

// In reverse order, because results must not depend on it.
template <class F>
void ForEachBackwards(Index count, const F& f) {
  for (Index i = count - 1; i >= 0; --i) f(i);
}

}  // namespace vesta::test
