// How a functor of residuals is called, everywhere: on entries that hold Unwritten, and with the bool that it may
// return.
#pragma once

#include <concepts>
#include <type_traits>

#include "kernels/math/dual.h"
#include "solver/unwritten.h"

namespace vesta {

namespace functor_internal {

template <std::floating_point S>
VESTA_HD void Forget(S& entry) {
  entry = Unwritten<S>();
}
template <class S>
VESTA_HD void Forget(Dual<S>& entry) {
  Forget(entry.v);
  Forget(entry.d);
}

}  // namespace functor_internal

// f(arguments...), which returns bool, or void for true.
template <class F, class... Arguments>
VESTA_HD bool InvokeFunctor(const F& f, Arguments... arguments) {
  if constexpr (std::is_same_v<decltype(f(arguments...)), bool>) {
    return f(arguments...);
  } else {
    f(arguments...);
    return true;
  }
}

// f(blocks..., r), where r has `residuals` entries. false: f returned false, so that r has no value. Where the compiler
// sees that f writes all of r, nothing is filled.
template <class F, class T, class... Blocks>
VESTA_HD bool CallFunctor(const F& f, int residuals, T* r, const Blocks*... blocks) {
  for (int i = 0; i < residuals; ++i) functor_internal::Forget(r[i]);
  return InvokeFunctor(f, blocks..., r);
}

}  // namespace vesta
