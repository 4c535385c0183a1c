// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/block_diagonal.h"
#include "kernels/core/block_lanes.h"
#include "kernels/core/error.h"
#include "kernels/core/launch.cuh"

namespace vesta::device {
namespace {

template <class S>
using Lane = BlockLanes<S, 1>;

// The common orders (scalars, points, cameras, Gaussians) are compile-time constants, so that a block stays in
// registers. -n stands for any order up to n; the block is then an array of capacity n in local memory.
template <int kOrder>
constexpr int kCapacity = kOrder > 0 ? kOrder : -kOrder;
constexpr int kMiddleOrder = 16;

template <int kOrder, class S>
__device__ void Load(const BlockGroup& group, int order, Index block, const S* values, Lane<S>* out) {
  const int packed = PackedLower(order, 0);
#pragma unroll
  for (int k = 0; k < packed; ++k) out[k].lane[0] = values[k * group.count + block];
}

template <int kOrder>
constexpr int kPacked = PackedSize(kCapacity<kOrder>);

// Calls kernel<order>().
template <class Call>
void WithOrder(const BlockGroup& group, const Call& call) {
  switch (group.size) {
    case 1:
      return call(std::integral_constant<int, 1>{});
    case 3:
      return call(std::integral_constant<int, 3>{});
    case 9:
      return call(std::integral_constant<int, 9>{});
    case 11:
      return call(std::integral_constant<int, 11>{});
    default:
      if (group.size <= kMiddleOrder) return call(std::integral_constant<int, -kMiddleOrder>{});
      if (group.size > kMaxBlockOrder) {
        throw Error(kUnsupported, "blocks of order " + std::to_string(group.size) + " on a GPU, where " +
                                      std::to_string(kMaxBlockOrder) + " is the largest; use the CPU");
      }
      return call(std::integral_constant<int, -kMaxBlockOrder>{});
  }
}

template <int kOrder, class S>
struct Multiply {
  BlockGroup group;
  const S *values, *x;
  S* y;
  __device__ void operator()(Index block) const {
    const int order = kOrder > 0 ? kOrder : group.size;
    Lane<S> a[kPacked<kOrder>], in[kCapacity<kOrder>], out[kCapacity<kOrder>];
    Load<kOrder>(group, order, block, values, a);
    for (int c = 0; c < order; ++c) in[c].lane[0] = x[group.Parameter(block, c)];
    MultiplyLanes<1>(order, a, in, out);
    for (int c = 0; c < order; ++c) y[group.Parameter(block, c)] = out[c].lane[0];
  }
};

template <int kOrder, class S>
struct Factorize {
  static constexpr int kMinBlocks = 1;
  BlockGroup group;
  S* values;
  unsigned long long* num_replaced;
  __device__ void operator()(Index block) const {
    const int order = kOrder > 0 ? kOrder : group.size;
    Lane<S> a[kPacked<kOrder>], root[kCapacity<kOrder>], scale[kCapacity<kOrder>], left[kCapacity<kOrder>];
    Load<kOrder>(group, order, block, values, a);
    BlockLanes<int, 1> count{};
    FactorizeLanes<1>(order, a, root, scale, left, count);
    const int packed = PackedLower(order, 0);
#pragma unroll
    for (int k = 0; k < packed; ++k) values[k * group.count + block] = a[k].lane[0];
    // Integers, so the sum does not depend on the order of the threads.
    if (count.lane[0] > 0) atomicAdd(num_replaced, static_cast<unsigned long long>(count.lane[0]));
  }
};

template <int kOrder, class S>
struct Solve {
  BlockGroup group;
  const S *values, *x;
  S* y;
  __device__ void operator()(Index block) const {
    const int order = kOrder > 0 ? kOrder : group.size;
    Lane<S> a[kPacked<kOrder>], v[kCapacity<kOrder>];
    Load<kOrder>(group, order, block, values, a);
    for (int c = 0; c < order; ++c) v[c].lane[0] = x[group.Parameter(block, c)];
    SolveLanes<1>(order, a, v);
    for (int c = 0; c < order; ++c) y[group.Parameter(block, c)] = v[c].lane[0];
  }
};

}  // namespace

template <class S>
void AddToBlockDiagonal(const BlockGroup& group, double scale, const S* d, S* values) {
  const S s = static_cast<S>(scale);
  for (int c = 0; c < group.size; ++c) {
    S* diagonal = values + PackedLower(c, c) * group.count;
    ForEach(
        group.count, [=] __device__(Index i) { diagonal[i] += s * d[group.Parameter(i, c)]; }, "AddToDiagonal");
  }
}

template <class S>
void BlockDiagonalOf(const BlockGroup& group, const S* values, S* out) {
  for (int c = 0; c < group.size; ++c) {
    const S* diagonal = values + PackedLower(c, c) * group.count;
    ForEach(
        group.count, [=] __device__(Index i) { out[group.Parameter(i, c)] = diagonal[i]; }, "Diagonal");
  }
}

template <class S>
void MultiplyBlocks(const BlockGroup& group, const S* values, const S* x, S* y) {
  WithOrder(group, [&](auto order) {
    ForEach(group.count, Multiply<decltype(order)::value, S>{group, values, x, y}, "BlockDiagonal::Apply");
  });
}

template <class S>
void FactorizeBlocks(const BlockGroup& group, S* values, unsigned long long* num_replaced) {
  WithOrder(group, [&](auto order) {
    ForEach(group.count, Factorize<decltype(order)::value, S>{group, values, num_replaced}, "BlockDiagonal::Factorize");
  });
}

template <class S>
void SolveBlocks(const BlockGroup& group, const S* values, const S* x, S* y) {
  WithOrder(group, [&](auto order) {
    ForEach(group.count, Solve<decltype(order)::value, S>{group, values, x, y}, "BlockDiagonal::Solve");
  });
}

#define VESTA_INSTANTIATE(S)                                                 \
  template void AddToBlockDiagonal(const BlockGroup&, double, const S*, S*); \
  template void BlockDiagonalOf(const BlockGroup&, const S*, S*);            \
  template void MultiplyBlocks(const BlockGroup&, const S*, const S*, S*);   \
  template void FactorizeBlocks(const BlockGroup&, S*, unsigned long long*); \
  template void SolveBlocks(const BlockGroup&, const S*, const S*, S*);
VESTA_INSTANTIATE(float)
VESTA_INSTANTIATE(double)
#undef VESTA_INSTANTIATE

}  // namespace vesta::device
