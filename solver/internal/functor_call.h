// SPDX-License-Identifier: Apache-2.0
// How a functor of residuals is called, everywhere.
#pragma once

#include <concepts>
#include <type_traits>

#include "kernels/math/dual.h"
#include "solver/internal/unwritten.h"

namespace vesta {

template <std::floating_point S>
VESTA_HD void Forget(S& entry) {
  entry = Unwritten<S>();
}
template <class S>
VESTA_HD void Forget(Dual<S>& entry) {
  Forget(entry.a);
  Forget(entry.v);
}
// Before the functor is called on them, however often: what it never writes stays Unwritten. Where the compiler sees
// that it writes all, nothing is filled.
template <class T>
VESTA_HD void Forget(int count, T* entries) {
  for (int i = 0; i < count; ++i) Forget(entries[i]);
}

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

}  // namespace vesta
