// Block-diagonal matrices on the host. Sixteen blocks are worked on side by side, one SIMD lane each: every inner loop
// below runs over the lanes, so a group of 11 x 11 blocks costs what its memory traffic costs.
#include "kernels/core/block_diagonal.h"

#include <cmath>
#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/vector_backend.h"

namespace vesta {
namespace {

constexpr int kLanes = 16;
// Blocks in one task.
constexpr Index kGrain = 64 * kLanes;

template <class S>
struct alignas(64) Lanes {
  S lane[kLanes];
};

// Smallest pivot of a block scaled to a unit diagonal.
template <class S>
constexpr S kSmallestPivot = sizeof(S) == sizeof(float) ? S(1e-6) : S(1e-13);

// Calls body(first_block, lanes_in_use, scratch) for every sixteen blocks of a group, on all threads; scratch has
// `scratch_size` elements.
template <class S, class Body>
void ForEachLanes(Index count, int scratch_size, const Body& body) {
  ParallelForChunks(count, kGrain, [&](Index begin, Index end) {
    std::vector<Lanes<S>> scratch(static_cast<std::size_t>(scratch_size));
    for (Index i = begin; i < end; i += kLanes) {
      body(i, static_cast<int>(std::min<Index>(kLanes, end - i)), scratch.data());
    }
  });
}

// Component `component` of blocks first..first + used - 1; unused lanes are 0.
template <class S>
void Gather(const BlockGroup& group, Index first, int used, int component, int copy, const S* x, Lanes<S>& out) {
  const S* source = x + group.Parameter(first, component, copy);
  if (group.block_stride == 1 && used == kLanes) {
    for (int l = 0; l < kLanes; ++l) out.lane[l] = source[l];
    return;
  }
  out = Lanes<S>{};
  for (int l = 0; l < used; ++l) out.lane[l] = source[l * group.block_stride];
}

template <class S>
void Scatter(const BlockGroup& group, Index first, int used, int component, int copy, const Lanes<S>& in, S* y) {
  S* target = y + group.Parameter(first, component, copy);
  if (group.block_stride == 1 && used == kLanes) {
    for (int l = 0; l < kLanes; ++l) target[l] = in.lane[l];
    return;
  }
  for (int l = 0; l < used; ++l) target[l * group.block_stride] = in.lane[l];
}

// The packed lower triangles of the blocks; unused lanes are 0.
template <class S>
void LoadBlocks(const BlockGroup& group, const S* values, Index first, int used, Lanes<S>* out) {
  const int packed = PackedLower(group.size, 0);
  for (int k = 0; k < packed; ++k) {
    const S* source = values + k * group.count + first;
    if (used == kLanes) {
      for (int l = 0; l < kLanes; ++l) out[k].lane[l] = source[l];
    } else {
      out[k] = Lanes<S>{};
      for (int l = 0; l < used; ++l) out[k].lane[l] = source[l];
    }
  }
}

template <class S>
void StoreBlocks(const BlockGroup& group, const Lanes<S>* in, Index first, int used, S* values) {
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

// Cholesky factors of sixteen blocks, in place: L below the diagonal, 1 / L_kk on it. The blocks are scaled to a unit
// diagonal first. In a positive semidefinite matrix no entry of L exceeds the root of what is left of its row's
// diagonal; holding every entry to that bound keeps all numbers finite whatever the input. Adds to `treated` the number
// of pivots that were replaced. root, scale and left are scratch for `size` elements each.
template <class S>
void FactorizeLanes(int size, Lanes<S>* a, Lanes<S>* root, Lanes<S>* scale, Lanes<S>* left, Lanes<int>& treated) {
  for (int i = 0; i < size; ++i) {
    const Lanes<S> d = a[PackedLower(i, i)];
    for (int l = 0; l < kLanes; ++l) {
      const bool usable = d.lane[l] > S(0) && d.lane[l] <= std::numeric_limits<S>::max();
      const S r = std::sqrt(usable ? d.lane[l] : S(1)), inverse = S(1) / r;
      root[i].lane[l] = usable ? r : S(0);
      scale[i].lane[l] = usable ? inverse : S(0);
      left[i].lane[l] = S(1);
      treated.lane[l] += usable ? 0 : 1;
    }
  }
  for (int i = 0; i < size; ++i) {
    const Lanes<S> row = scale[i];
    for (int j = 0; j < i; ++j) {
      const Lanes<S> bound = root[j], column = scale[j];
      Lanes<S>& entry = a[PackedLower(i, j)];
      for (int l = 0; l < kLanes; ++l) {
        // Clamped between the two factors, so that neither product can overflow.
        const S half = entry.lane[l] * row.lane[l];
        entry.lane[l] = std::min(std::max(half, -bound.lane[l]), bound.lane[l]) * column.lane[l];
      }
    }
  }
  for (int j = 0; j < size; ++j) {
    Lanes<S> inverse;
    for (int l = 0; l < kLanes; ++l) {
      const S pivot = std::max(left[j].lane[l], kSmallestPivot<S>);
      treated.lane[l] += ((pivot > left[j].lane[l]) & (root[j].lane[l] > S(0))) ? 1 : 0;
      inverse.lane[l] = S(1) / std::sqrt(pivot);
    }
    for (int i = j + 1; i < size; ++i) {
      Lanes<S> sum = a[PackedLower(i, j)], rest = left[i];
      for (int k = 0; k < j; ++k) {
        const Lanes<S>&x = a[PackedLower(i, k)], &y = a[PackedLower(j, k)];
        for (int l = 0; l < kLanes; ++l) sum.lane[l] -= x.lane[l] * y.lane[l];
      }
      for (int l = 0; l < kLanes; ++l) {
        const S bound = std::sqrt(rest.lane[l]);
        sum.lane[l] = std::min(std::max(sum.lane[l] * inverse.lane[l], -bound), bound);
        rest.lane[l] = std::max(rest.lane[l] - sum.lane[l] * sum.lane[l], S(0));
      }
      a[PackedLower(i, j)] = sum;
      left[i] = rest;
    }
    a[PackedLower(j, j)] = inverse;
  }
  // Back to the scale of the matrix; the diagonal holds reciprocals, 0 where the row and column were taken as 0.
  for (int i = 0; i < size; ++i) {
    const Lanes<S> row = root[i], inverse = scale[i];
    for (int j = 0; j <= i; ++j) {
      Lanes<S>& entry = a[PackedLower(i, j)];
      const Lanes<S>& factor = j < i ? row : inverse;
      for (int l = 0; l < kLanes; ++l) entry.lane[l] *= factor.lane[l];
    }
  }
}

// x <- L^-T L^-1 x for sixteen blocks.
template <class S>
void SolveLanes(int size, const Lanes<S>* a, Lanes<S>* x) {
  for (int i = 0; i < size; ++i) {
    Lanes<S> sum = x[i];
    for (int k = 0; k < i; ++k) {
      for (int l = 0; l < kLanes; ++l) sum.lane[l] -= a[PackedLower(i, k)].lane[l] * x[k].lane[l];
    }
    for (int l = 0; l < kLanes; ++l) x[i].lane[l] = sum.lane[l] * a[PackedLower(i, i)].lane[l];
  }
  for (int i = size - 1; i >= 0; --i) {
    Lanes<S> sum = x[i];
    for (int k = i + 1; k < size; ++k) {
      for (int l = 0; l < kLanes; ++l) sum.lane[l] -= a[PackedLower(k, i)].lane[l] * x[k].lane[l];
    }
    for (int l = 0; l < kLanes; ++l) x[i].lane[l] = sum.lane[l] * a[PackedLower(i, i)].lane[l];
  }
}

// y = A x for sixteen blocks.
template <class S>
void MultiplyLanes(int size, const Lanes<S>* a, const Lanes<S>* x, Lanes<S>* y) {
  for (int i = 0; i < size; ++i) {
    Lanes<S> sum{};
    for (int k = 0; k < size; ++k) {
      const Lanes<S>& entry = a[i >= k ? PackedLower(i, k) : PackedLower(k, i)];
      for (int l = 0; l < kLanes; ++l) sum.lane[l] += entry.lane[l] * x[k].lane[l];
    }
    y[i] = sum;
  }
}

// Lowest and highest parameter a group touches.
std::pair<Index, Index> Range(const BlockGroup& group) {
  Index lowest = group.offset, highest = group.offset;
  for (const Index reach : {(group.size - 1) * group.component_stride, (group.count - 1) * group.block_stride,
                            (group.copies - 1) * group.copy_stride}) {
    lowest += std::min<Index>(reach, 0);
    highest += std::max<Index>(reach, 0);
  }
  return {lowest, highest};
}

}  // namespace

template <class B>
BlockDiagonal<B>::BlockDiagonal(Index num_parameters, std::vector<BlockGroup> groups)
    : num_parameters_(num_parameters), groups_(std::move(groups)) {
  Index covered = 0, values = 0;
  for (const BlockGroup& group : groups_) {
    VESTA_CHECK(group.size >= 1 && group.count >= 0 && group.copies >= 1,
                "block group of {} blocks of size {}, {} times", group.count, group.size, group.copies);
    if (group.count > 0) {
      const auto [lowest, highest] = Range(group);
      VESTA_CHECK(lowest >= 0 && highest < num_parameters, "a block group covers parameters {} to {} of {}", lowest,
                  highest, num_parameters);
    }
    first_value_.push_back(values);
    covered += group.count * group.size * group.copies;
    values += group.NumValues();
  }
  VESTA_CHECK(covered == num_parameters, "block groups cover {} of {} parameters", covered, num_parameters);
  values_.Resize(values);
}

template <class B>
typename B::View BlockDiagonal<B>::values(int group) {
  const auto g = static_cast<std::size_t>(group);
  return all_values().subspan(first_value_[g], groups_[g].NumValues());
}

template <class B>
typename B::ConstView BlockDiagonal<B>::values(int group) const {
  const auto g = static_cast<std::size_t>(group);
  return values_.view().subspan(first_value_[g], groups_[g].NumValues());
}

template <class B>
typename B::View BlockDiagonal<B>::all_values() {
  return values_.view();
}

template <class B>
void BlockDiagonal<B>::Add(double scale, const BlockDiagonal& other) {
  B().Axpby(scale, other.values_.view(), 1.0, values_.view());
}

template <class B>
void BlockDiagonal<B>::AddToDiagonal(double scale, typename B::ConstView d) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const Scalar s = static_cast<Scalar>(scale / group.copies);
    for (int c = 0; c < group.size; ++c) {
      Scalar* diagonal = values_.data() + first_value_[g] + PackedLower(c, c) * group.count;
      ParallelFor(group.count, kGrain, [&](Index i) {
        for (int copy = 0; copy < group.copies; ++copy) diagonal[i] += s * d[group.Parameter(i, c, copy)];
      });
    }
  }
}

template <class B>
void BlockDiagonal<B>::Diagonal(typename B::View out) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    for (int c = 0; c < group.size; ++c) {
      const Scalar* diagonal = values_.data() + first_value_[g] + PackedLower(c, c) * group.count;
      ParallelFor(group.count, kGrain, [&](Index i) {
        for (int copy = 0; copy < group.copies; ++copy) out[group.Parameter(i, c, copy)] = diagonal[i];
      });
    }
  }
}

template <class B>
void BlockDiagonal<B>::Apply(typename B::ConstView x, typename B::View y) const {
  VESTA_CHECK(x.size() == num_parameters_ && y.size() == num_parameters_, "vectors of {} and {} entries, matrix of {}",
              x.size(), y.size(), num_parameters_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const int size = group.size, packed = PackedLower(size, 0);
    ForEachLanes<Scalar>(group.count, packed + 2 * size, [&](Index first, int used, Lanes<Scalar>* scratch) {
      Lanes<Scalar>*a = scratch, *in = a + packed, *out = in + size;
      LoadBlocks(group, values_.data() + first_value_[g], first, used, a);
      for (int copy = 0; copy < group.copies; ++copy) {
        for (int c = 0; c < size; ++c) Gather(group, first, used, c, copy, x.data(), in[c]);
        MultiplyLanes(size, a, in, out);
        for (int c = 0; c < size; ++c) Scatter(group, first, used, c, copy, out[c], y.data());
      }
    });
  }
}

template <class B>
Index BlockDiagonal<B>::Factorize() {
  Index treated = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const int size = group.size, packed = PackedLower(size, 0);
    Scalar* values = values_.data() + first_value_[g];
    treated += ParallelSum<Index>(group.count, kGrain, [&](Index begin, Index end) {
      std::vector<Lanes<Scalar>> scratch(static_cast<std::size_t>(packed + 3 * size));
      Lanes<Scalar>*a = scratch.data(), *root = a + packed, *scale = root + size, *left = scale + size;
      Index count = 0;
      for (Index first = begin; first < end; first += kLanes) {
        const int used = static_cast<int>(std::min<Index>(kLanes, end - first));
        Lanes<int> lanes_treated{};
        LoadBlocks(group, values, first, used, a);
        FactorizeLanes(size, a, root, scale, left, lanes_treated);
        StoreBlocks(group, a, first, used, values);
        for (int l = 0; l < used; ++l) count += lanes_treated.lane[l];
      }
      return count;
    });
  }
  return treated;
}

template <class B>
void BlockDiagonal<B>::Solve(typename B::ConstView x, typename B::View y) const {
  VESTA_CHECK(x.size() == num_parameters_ && y.size() == num_parameters_, "vectors of {} and {} entries, matrix of {}",
              x.size(), y.size(), num_parameters_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const BlockGroup& group = groups_[g];
    const int size = group.size, packed = PackedLower(size, 0);
    ForEachLanes<Scalar>(group.count, packed + size, [&](Index first, int used, Lanes<Scalar>* scratch) {
      Lanes<Scalar>*a = scratch, *v = a + packed;
      LoadBlocks(group, values_.data() + first_value_[g], first, used, a);
      for (int copy = 0; copy < group.copies; ++copy) {
        for (int c = 0; c < size; ++c) Gather(group, first, used, c, copy, x.data(), v[c]);
        SolveLanes(size, a, v);
        for (int c = 0; c < size; ++c) Scatter(group, first, used, c, copy, v[c], y.data());
      }
    });
  }
}

template class BlockDiagonal<CpuBackend<float>>;
template class BlockDiagonal<CpuBackend<double>>;

}  // namespace vesta
