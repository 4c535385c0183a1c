// Sums over images, in double; the same bits for any number of threads.
#pragma once

#include <type_traits>

#include "kernels/core/parallel.h"
#include "kernels/core/vector_backend.h"

namespace vesta::gs {

inline constexpr Index kImageGrain = 1 << 15;  // pixels

// of(i) summed over i < n.
template <class Of>
double SumOver(Index n, const Of& of) {
  return ParallelSum<double>(n, kImageGrain, [&](Index begin, Index end) {
    double sum = 0;
    for (Index i = begin; i < end; ++i) sum += of(i);
    return sum;
  });
}

template <class S, class U>
double Dot(const S* a, const U* b, Index n) {
  return SumOver(n, [&](Index i) { return static_cast<double>(a[i]) * static_cast<double>(b[i]); });
}

template <class S>
double Sum(const S* a, Index n) {
  return SumOver(n, [&](Index i) { return static_cast<double>(a[i]); });
}

// The same in the memory of B, read back at once.
template <class B>
double Dot(B& backend, typename B::ConstView a, typename B::ConstView b) {
  if constexpr (std::is_same_v<typename B::Space, Host>) {
    return Dot(a.data(), b.data(), a.size());
  } else {
    return backend.Dot(a, b);
  }
}

template <class B>
double Sum(B& backend, typename B::ConstView a) {
  if constexpr (std::is_same_v<typename B::Space, Host>) {
    return Sum(a.data(), a.size());
  } else {
    typename B::Vector ones;
    ones.ResizeForOverwrite(a.size());
    backend.Fill(1, ones);
    return backend.Dot(a, ones);
  }
}

}  // namespace vesta::gs
