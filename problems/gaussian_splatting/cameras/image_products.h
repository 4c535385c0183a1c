// Sums over images, in double; the same bits for any number of threads.
#pragma once

#include "kernels/core/parallel.h"

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

}  // namespace vesta::gs
