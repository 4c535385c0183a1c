// SPDX-License-Identifier: Apache-2.0
// GPU kernels, in plain C++, whose threads work together. A block kernel is a struct with
//
//   static constexpr int kThreads;            threads of a block, a multiple of 32
//   struct Shared;                            shared memory: plain arrays, not initialised, up to 48 KiB
//   template <class Block>
//   VESTA_HD void operator()(Block& block, Shared& shared) const;      the code of one thread
//
// The code accesses the GPU only through these functions of Block:
//
//   int thread(), Index id()     index of the thread in its block, of the block in the grid
//   void Sync()                  a barrier: waits until all threads of the block have called it
//   int Count(bool)              a barrier that also returns the number of threads that passed true
//
// launch.cuh runs a block kernel on a device. Tests run the same struct on the host, with one fiber per thread and in
// several orders (tests/support/emulated_block.h). They find missing barriers, indices out of range, and barriers that
// some threads never reach.
#pragma once

#include "kernels/core/span.h"

namespace vesta {

// Combines the values of all threads with `add`, in a fixed order. Every thread must call it. Thread 0 gets the result,
// the others their own value. lanes: kThreads values in shared memory. kThreads must be a power of two.
template <int kThreads, class Block, class T, class Add>
VESTA_HD inline T ReduceBlock(Block& block, T* lanes, const T& value, const Add& add) {
  static_assert((kThreads & (kThreads - 1)) == 0);
  const int thread = block.thread();
  lanes[thread] = value;
  block.Sync();
  for (int half = kThreads / 2; half > 0; half /= 2) {
    if (thread < half) lanes[thread] = add(lanes[thread], lanes[thread + half]);
    block.Sync();
  }
  // After the last barrier only thread 0 reads, and only lanes[0]. So each thread may overwrite its own element at
  // once, as the next call of this function does.
  return thread == 0 ? lanes[0] : value;
}

struct AddUp {
  template <class T>
  VESTA_HD T operator()(const T& a, const T& b) const {
    return a + b;
  }
};
// Maximum; NaN if either argument is NaN.
struct LargestOrNaN {
  template <class T>
  VESTA_HD T operator()(const T& a, const T& b) const {
    return b > a || b != b ? b : a;
  }
};

// Each block of threads combines the values term(i) of one chunk of [0, size) with `add` and stores result[block].
// Chunks have `chunk` indices, the last one perhaps fewer. With chunk = ChunkSize(size), which depends only on `size`,
// every GPU combines the values in the same order and gets the same result. term: VESTA_HD double(Index). add: `add(0,
// x)` must be x.
template <class Term, class Add>
struct ReduceChunks {
  static constexpr int kThreads = 256;
  struct Shared {
    double lanes[kThreads];
  };
  Term term;
  Add add;
  Index size, chunk;
  double* result;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const Index begin = block.id() * chunk, end = begin + chunk < size ? begin + chunk : size;
    double sum = 0;
    for (Index i = begin + block.thread(); i < end; i += kThreads) sum = add(sum, term(i));
    sum = ReduceBlock<kThreads>(block, shared.lanes, sum, add);
    if (block.thread() == 0) result[block.id()] = sum;
  }
};

// Each block of threads computes kSums sums over one chunk of [0, size) and stores sum k in result[kSums * block + k].
// term: VESTA_HD void(Index i, double sums[kSums]); adds the kSums values of index i to `sums`, one to each.
template <int kSums, class Term>
struct SumChunks {
  static constexpr int kThreads = 256;
  struct Shared {
    double lanes[kThreads];
  };
  Term term;
  Index size, chunk;
  double* result;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const Index begin = block.id() * chunk, end = begin + chunk < size ? begin + chunk : size;
    double sums[kSums] = {};
    for (Index i = begin + block.thread(); i < end; i += kThreads) term(i, sums);
    for (int k = 0; k < kSums; ++k) {
      const double sum = ReduceBlock<kThreads>(block, shared.lanes, sums[k], AddUp());
      if (block.thread() == 0) result[kSums * block.id() + k] = sum;
    }
  }
};

// Number of indices per chunk in a reduction of `size` terms. There are at most kMaxChunks chunks. Each one except the
// last has at least 4096 indices, because launching a block of threads costs more than a shorter sum.
inline constexpr Index kMaxChunks = 2048;
constexpr Index ChunkSize(Index size) {
  constexpr Index kShortest = 4096, kStep = 256;
  const Index even = (size + kMaxChunks - 1) / kMaxChunks;
  return even <= kShortest ? kShortest : (even + kStep - 1) / kStep * kStep;
}

}  // namespace vesta
