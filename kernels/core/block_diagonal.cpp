// SPDX-License-Identifier: Apache-2.0
// Block-diagonal matrices on the host. Each SIMD lane processes one of sixteen blocks, and every inner loop runs over
// the lanes. A group of 11 x 11 blocks then takes no longer than its memory traffic.
#include "kernels/core/block_diagonal.inl"

#include "kernels/core/block_lanes.h"
#include "kernels/core/parallel.h"
#include "kernels/core/vector_backend.h"

namespace vesta {
namespace {

constexpr int kLanes = 16;
// Blocks in one task.
constexpr Index kGrain = 64 * kLanes;

template <class S>
using Lanes16 = BlockLanes<S, kLanes>;

// Calls body(first_block, lanes_in_use, scratch) for each set of sixteen blocks, on all threads. scratch has
// `scratch_size` elements.
template <class S, class Body>
void ForEachLanes(Index count, int scratch_size, const Body& body) {
  ParallelForChunks(count, kGrain, [&](Index begin, Index end) {
    std::vector<Lanes16<S>> scratch(static_cast<std::size_t>(scratch_size));
    for (Index i = begin; i < end; i += kLanes) {
      body(i, static_cast<int>(std::min<Index>(kLanes, end - i)), scratch.data());
    }
  });
}

// Component `component` of blocks first..first + used - 1; unused lanes are 0.
template <class S>
void Gather(const BlockGroup& group, Index first, int used, int component, const S* x, Lanes16<S>& out) {
  const S* source = x + group.Parameter(first, component);
  if (group.block_stride == 1 && used == kLanes) {
    for (int l = 0; l < kLanes; ++l) out.lane[l] = source[l];
    return;
  }
  out = Lanes16<S>{};
  for (int l = 0; l < used; ++l) out.lane[l] = source[l * group.block_stride];
}

template <class S>
void Scatter(const BlockGroup& group, Index first, int used, int component, const Lanes16<S>& in, S* y) {
  S* target = y + group.Parameter(first, component);
  if (group.block_stride == 1 && used == kLanes) {
    for (int l = 0; l < kLanes; ++l) target[l] = in.lane[l];
    return;
  }
  for (int l = 0; l < used; ++l) target[l * group.block_stride] = in.lane[l];
}

// The packed lower triangles of the blocks; unused lanes are 0.
template <class S>
void LoadBlocks(const BlockGroup& group, const S* values, Index first, int used, Lanes16<S>* out) {
  const int packed = PackedLower(group.size, 0);
  for (int k = 0; k < packed; ++k) {
    const S* source = values + k * group.count + first;
    if (used == kLanes) {
      for (int l = 0; l < kLanes; ++l) out[k].lane[l] = source[l];
    } else {
      out[k] = Lanes16<S>{};
      for (int l = 0; l < used; ++l) out[k].lane[l] = source[l];
    }
  }
}

template <class S>
void StoreBlocks(const BlockGroup& group, const Lanes16<S>* in, Index first, int used, S* values) {
  const int packed = PackedLower(group.size, 0);
  for (int k = 0; k < packed; ++k) {
    S* target = values + k * group.count + first;
    if (used == kLanes) {
      for (int l = 0; l < kLanes; ++l) target[l] = in[k].lane[l];
    } else {
      for (int l = 0; l < used; ++l) target[l] = in[k].lane[l];
    }
  }
}

}  // namespace

template <class B>
void BlockDiagonal<B>::AddToDiagonal(double scale, typename B::ConstVectorView d) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const Scalar s = static_cast<Scalar>(scale);
    for (int c = 0; c < group.size; ++c) {
      Scalar* diagonal = values_.data() + first_value_[g] + PackedLower(c, c) * group.count;
      ParallelFor(group.count, kGrain, [&](Index i) { diagonal[i] += s * d[group.Parameter(i, c)]; });
    }
  }
}

template <class B>
void BlockDiagonal<B>::Diagonal(typename B::VectorView out) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    for (int c = 0; c < group.size; ++c) {
      const Scalar* diagonal = values_.data() + first_value_[g] + PackedLower(c, c) * group.count;
      ParallelFor(group.count, kGrain, [&](Index i) { out[group.Parameter(i, c)] = diagonal[i]; });
    }
  }
}

template <class B>
void BlockDiagonal<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) const {
  VESTA_CHECK(x.size() == num_parameters_ && y.size() == num_parameters_, "vectors of {} and {} entries, matrix of {}",
              x.size(), y.size(), num_parameters_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const int size = group.size, packed = PackedLower(size, 0);
    ForEachLanes<Scalar>(group.count, packed + 2 * size, [&](Index first, int used, Lanes16<Scalar>* scratch) {
      Lanes16<Scalar>*a = scratch, *in = a + packed, *out = in + size;
      LoadBlocks(group, values_.data() + first_value_[g], first, used, a);
      for (int c = 0; c < size; ++c) Gather(group, first, used, c, x.data(), in[c]);
      MultiplyLanes(size, a, in, out);
      for (int c = 0; c < size; ++c) Scatter(group, first, used, c, out[c], y.data());
    });
  }
}

template <class B>
Index BlockDiagonal<B>::Factorize() {
  Index num_replaced = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const int size = group.size, packed = PackedLower(size, 0);
    Scalar* values = values_.data() + first_value_[g];
    num_replaced += ParallelSum<Index>(group.count, kGrain, [&](Index begin, Index end) {
      std::vector<Lanes16<Scalar>> scratch(static_cast<std::size_t>(packed + 3 * size));
      Lanes16<Scalar>*a = scratch.data(), *root = a + packed, *scale = root + size, *left = scale + size;
      Index count = 0;
      for (Index first = begin; first < end; first += kLanes) {
        const int used = static_cast<int>(std::min<Index>(kLanes, end - first));
        Lanes16<int> lanes_replaced{};
        LoadBlocks(group, values, first, used, a);
        FactorizeLanes(size, a, root, scale, left, lanes_replaced);
        StoreBlocks(group, a, first, used, values);
        for (int l = 0; l < used; ++l) count += lanes_replaced.lane[l];
      }
      return count;
    });
  }
  return num_replaced;
}

template <class B>
void BlockDiagonal<B>::Solve(typename B::ConstVectorView x, typename B::VectorView y) const {
  VESTA_CHECK(x.size() == num_parameters_ && y.size() == num_parameters_, "vectors of {} and {} entries, matrix of {}",
              x.size(), y.size(), num_parameters_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const int size = group.size, packed = PackedLower(size, 0);
    ForEachLanes<Scalar>(group.count, packed + size, [&](Index first, int used, Lanes16<Scalar>* scratch) {
      Lanes16<Scalar>*a = scratch, *v = a + packed;
      LoadBlocks(group, values_.data() + first_value_[g], first, used, a);
      for (int c = 0; c < size; ++c) Gather(group, first, used, c, x.data(), v[c]);
      SolveLanes(size, a, v);
      for (int c = 0; c < size; ++c) Scatter(group, first, used, c, v[c], y.data());
    });
  }
}

template class BlockDiagonal<CpuBackend<float>>;
template class BlockDiagonal<CpuBackend<double>>;

}  // namespace vesta
