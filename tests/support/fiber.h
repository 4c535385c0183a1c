// SPDX-License-Identifier: Apache-2.0
// Fibers: functions with their own stacks, between which a thread switches. They emulate the threads of a GPU block.
#pragma once

#include <ucontext.h>

#include <cstddef>
#include <cstdint>

namespace vesta::test {

// The state of a fiber, or of the thread that runs fibers, while it does not run.
struct FiberContext {
  ucontext_t context{};
  void* resume[5]{};
  bool begun = true;
};

// A fiber's function must not return, but switch to another fiber when its work is done.
using FiberFunction = void (*)(std::uintptr_t argument);

namespace fiber_internal {

// makecontext passes arguments of type int.
inline void Enter(unsigned function_high, unsigned function_low, unsigned argument_high, unsigned argument_low) {
  const auto function = reinterpret_cast<FiberFunction>(std::uintptr_t{function_high} << 32 | function_low);
  function(std::uintptr_t{argument_high} << 32 | argument_low);
}

}  // namespace fiber_internal

// The first SwitchFiber to `fiber` then calls function(argument) on this stack, which must outlive it.
inline void PrepareFiber(FiberContext& fiber, char* stack, std::size_t stack_bytes, FiberFunction function,
                         std::uintptr_t argument) {
  getcontext(&fiber.context);
  fiber.context.uc_stack.ss_sp = stack;
  fiber.context.uc_stack.ss_size = stack_bytes;
  fiber.context.uc_link = nullptr;
  fiber.begun = false;
  const auto address = reinterpret_cast<std::uintptr_t>(function);
  makecontext(&fiber.context, reinterpret_cast<void (*)()>(&fiber_internal::Enter), 4,
              static_cast<unsigned>(address >> 32), static_cast<unsigned>(address),
              static_cast<unsigned>(argument >> 32), static_cast<unsigned>(argument));
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// Leaves `from` and continues in `to`. swapcontext tells sanitizers about the other stack.
inline void SwitchFiber(FiberContext& from, FiberContext& to) { swapcontext(&from.context, &to.context); }

#else

namespace fiber_internal {

// Not inlined, because __builtin_longjmp must not jump within one function.
[[gnu::noinline, noreturn]] inline void Resume(FiberContext& to) {
  if (!to.begun) {
    to.begun = true;
    setcontext(&to.context);
  }
  __builtin_longjmp(to.resume, 1);
}

}  // namespace fiber_internal

// Leaves `from` and continues in `to`, in tens of nanoseconds. swapcontext takes microseconds, for a system call for
// the signal mask.
[[gnu::noinline]] inline void SwitchFiber(FiberContext& from, FiberContext& to) {
  if (__builtin_setjmp(from.resume) == 0) fiber_internal::Resume(to);
}

#endif

}  // namespace vesta::test
