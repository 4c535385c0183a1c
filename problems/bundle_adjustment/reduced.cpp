// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/reduced.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/kernels.h"

namespace vesta::bundle::internal {
namespace {

constexpr Index kPointsPerTask = 1024;
constexpr Index kBlocksPerTask = 2048;

constexpr double kMaxBytes = 0x1p32;
// Limit for the cost of factorising, in multiplications per entry of the matrix. Factorising a front does about ten
// multiplications per nanosecond, a product with the matrix about one.
constexpr double kMultiplicationsPerEntry = 1000;

std::vector<BlockGroup> PointBlocks(Index num_points) { return {{kPointSize, num_points, 0, 1, kPointSize}}; }

// Copies the blocks of a matrix, laid out as for SymmetricProduct (kernels.h), to a BlockMatrix with the same pattern.
void CopyBlocks(const ReducedPattern& pattern, const double* blocks, BlockMatrix& matrix) {
  const std::vector<Index>& block_of_pair = matrix.pattern().block_of_pair();
  ParallelFor(pattern.row_first.size() - 1, 16, [&](Index i) {
    for (Index k = pattern.row_first[i]; k < pattern.row_first[i + 1]; ++k) {
      const double* from = blocks + kBlockSize * k;
      // The numbering of pairs omits the diagonal block, which is the first block of each row.
      double* to = pattern.column[k] == i ? matrix.diagonal(i)
                                          : matrix.block(block_of_pair[static_cast<std::size_t>(k - i - 1)]);
      for (int r = 0; r < kCameraSize; ++r) {
        for (int c = 0; c < kCameraSize; ++c) to[kCameraSize * c + r] = from[kRowSize * r + kPointSize + c];
      }
    }
  });
}

}  // namespace

std::shared_ptr<ReducedCholeskyPlan> ReducedCholeskyPlan::Make(const ReducedPattern& pattern) {
  if (pattern.diagonal_only) return nullptr;
  const Index rows = pattern.row_first.size() - 1;
  std::vector<BlockPattern::Pair> pairs;
  for (Index i = 0; i < rows; ++i) {
    for (Index k = pattern.row_first[i] + 1; k < pattern.row_first[i + 1]; ++k) {
      pairs.push_back({i, Index{pattern.column[k]}});
    }
  }
  std::shared_ptr<ReducedCholeskyPlan> plan(new ReducedCholeskyPlan);
  const std::vector<int> sizes(static_cast<std::size_t>(rows), kCameraSize);
  plan->pattern_ = std::make_shared<const BlockPattern>(sizes, pairs);
  const auto entries = static_cast<double>(pattern.column.size()) * kCameraSize * kCameraSize;
  plan->cholesky_ = SparseCholesky::Plan(*plan->pattern_, kMaxBytes, kMultiplicationsPerEntry * entries);
  return plan->cholesky_ ? plan : nullptr;
}

template <class S>
BundleReducedSystem<S>::BundleReducedSystem(BundleContext& context, const LinearizationArrays<S>& arrays)
    : context_(context),
      structure_(context.structure),
      arrays_(arrays),
      kernels_(KernelsFor<S>(context.options.isa)),
      order_{structure_.track_first(), structure_.track_point(), structure_.camera(), arrays.records.data()},
      own_(context.reduced_pool.Get()),
      damping_(structure_.num_camera_parameters()),
      padded_(kRowSize * structure_.num_cameras()),
      scratch_(2 * structure_.longest_track() * structure_.num_chunks()),
      camera_sums_(structure_.num_cameras(), structure_.num_chunks()) {
  if (!own_->point_blocks) {
    own_->point_blocks.emplace(kPointSize * structure_.num_points(), PointBlocks(structure_.num_points()));
  }
  own_->inverse.ResizeForOverwrite(kPointGramSize * structure_.num_points());
  own_->blocks.ResizeForOverwrite(kBlockSize * context_.pattern.column.size());
  if (!explicit_form()) return;
  const HostBuffer<Index>& first = context_.pattern.row_first;
  const Index rows = structure_.num_cameras(), count = first[rows];
  row_chunks_.push_back(0);
  for (Index i = 1; i < rows; ++i) {
    if (first[i] - first[row_chunks_.back()] >= std::max(kBlocksPerTask, count / 32)) row_chunks_.push_back(i);
  }
  row_chunks_.push_back(rows);
  row_sums_.emplace(rows, static_cast<Index>(row_chunks_.size()) - 1);
}

template <class S>
void BundleReducedSystem<S>::SetDamping(double lambda, ConstVectorView metric) {
  VESTA_CHECK(metric.size() == structure_.num_parameters(), "the metric has {} entries for {} parameters",
              metric.size(), structure_.num_parameters());
  formed_ = false;
  for (Index k = 0; k < size(); ++k) damping_[k] = lambda * metric[k];
  InvertPointBlocks(lambda, metric.subspan(size(), kPointSize * structure_.num_points()));
}

template <class S>
void BundleReducedSystem<S>::InvertPointBlocks(double lambda, ConstVectorView metric) {
  const Index n = structure_.num_points();
  BlockDiagonal<Cpu>& point_blocks = *own_->point_blocks;
  std::copy(arrays_.point_gram.begin(), arrays_.point_gram.end(), point_blocks.all_values().begin());
  point_blocks.AddToDiagonal(lambda, metric);
  point_blocks.Factorize();
  ParallelFor(n, kPointsPerTask, [&](Index p) {
    const double* factor = point_blocks.all_values().data() + p;
    // M = L^-1; the diagonal of the factor holds reciprocals.
    const double m00 = factor[0], m11 = factor[2 * n], m22 = factor[5 * n];
    const double m10 = -m11 * factor[n] * m00, m21 = -m22 * factor[4 * n] * m11;
    const double m20 = -m22 * (factor[3 * n] * m00 + factor[4 * n] * m10);
    double* inverse = own_->inverse.data() + kPointGramSize * p;
    inverse[0] = m00 * m00 + m10 * m10 + m20 * m20;
    inverse[1] = m11 * m10 + m21 * m20;
    inverse[2] = m11 * m11 + m21 * m21;
    inverse[3] = m22 * m20;
    inverse[4] = m22 * m21;
    inverse[5] = m22 * m22;
  });
}

template <class S>
template <class Finish>
void BundleReducedSystem<S>::Reduce(const double* cameras, const double* b, const Finish& finish) {
  camera_sums_.Run(
      [&](Index k, double* sums) {
        double* scratch = scratch_.data() + 2 * structure_.longest_track() * k;
        kernels_.reduce(order_, Begin(k), End(k), own_->inverse.data(), cameras, b, scratch, sums);
      },
      finish);
}

template <class S>
void BundleReducedSystem<S>::ReduceRhs(ConstVectorView rhs, VectorView reduced) {
  std::fill(padded_.begin(), padded_.end(), 0.0);
  Reduce(padded_.data(), rhs.data() + size(), [&](Index i, const double* sums) {
    for (Index c = 0, k = kCameraSize * i; c < kCameraSize; ++c, ++k) reduced[k] = rhs[k] + sums[c];
  });
}

template <class S>
void BundleReducedSystem<S>::Apply(ConstVectorView x, VectorView y) {
  VESTA_CHECK(x.size() == size() && y.size() == size(), "vectors of {} and {} entries do not match a matrix of size {}",
              x.size(), y.size(), size());
  PadCameras(structure_.num_cameras(), x.data(), padded_.data());
  if (!explicit_form()) {
    Reduce(padded_.data(), nullptr, [&](Index i, const double* sums) {
      for (Index c = 0, k = kCameraSize * i; c < kCameraSize; ++c, ++k) y[k] = sums[c] + damping_[k] * x[k];
    });
    return;
  }
  FormBlocks();
  const SymmetricProduct product = SymmetricProductFor(context_.options.isa);
  row_sums_->Run(
      [&](Index chunk, double* sums) {
        const auto k = static_cast<std::size_t>(chunk);
        product(context_.pattern.row_first.data(), context_.pattern.column.data(), own_->blocks.data(), row_chunks_[k],
                row_chunks_[k + 1], padded_.data(), sums);
      },
      [&](Index i, const double* sums) { std::copy_n(sums, kCameraSize, y.data() + kCameraSize * i); });
}

template <class S>
void BundleReducedSystem<S>::BackSubstitute(ConstVectorView rhs, VectorView step) {
  PadCameras(structure_.num_cameras(), step.data(), padded_.data());
  ParallelFor(structure_.num_chunks(), 1, [&](Index k) {
    kernels_.back_substitute(order_, Begin(k), End(k), own_->inverse.data(), padded_.data(), rhs.data() + size(),
                             step.data() + size());
  });
}

template <class S>
void BundleReducedSystem<S>::StartDiagonalBlock(Index i, double* block) const {
  const double* gram = arrays_.camera_gram.data() + kCameraGramSize * i;
  for (int r = 0; r < kCameraSize; ++r) {
    for (int c = 0; c < kCameraSize; ++c) {
      const double damping = r == c ? damping_[kCameraSize * i + r] : 0.0;
      block[kRowSize * r + kPointSize + c] = gram[PackedLower(std::max(r, c), std::min(r, c))] + damping;
    }
  }
}

template <class S>
void BundleReducedSystem<S>::FormBlocks() {
  if (std::exchange(formed_, true)) return;
  const ReducedPattern& pattern = context_.pattern;
  ParallelForChunks(structure_.num_cameras(), 1, [&](Index begin, Index end) {
    std::vector<Index> pair_first;
    std::vector<ObservationPair> pairs;
    std::vector<double> scratch;
    for (Index i = begin; i < end; ++i) {
      const Index first = pattern.row_first[i], count = pattern.row_first[i + 1] - first;
      double* blocks = own_->blocks.data() + kBlockSize * first;
      std::fill_n(blocks, kBlockSize * count, 0.0);
      StartDiagonalBlock(i, blocks);
      structure_.ListPairs(i, pattern, pair_first, pairs);
      const CameraSlice own = structure_.camera_observations(i);
      scratch.resize(static_cast<std::size_t>(8 * own.count));
      kernels_.reduced_row(order_, own, own_->inverse.data(), count, pair_first.data(), pairs.data(), scratch.data(),
                           blocks);
    }
  });
}

template <class S>
void BundleReducedSystem<S>::DiagonalBlocks(BlockDiagonal<Cpu>& blocks) {
  FormBlocks();
  const Index cameras = structure_.num_cameras();
  typename Cpu::VectorView values = blocks.values(0);
  for (Index i = 0; i < cameras; ++i) {
    const double* block = own_->blocks.data() + kBlockSize * context_.pattern.row_first[i];
    for (int r = 0; r < kCameraSize; ++r) {
      for (int c = 0; c <= r; ++c) values[PackedLower(r, c) * cameras + i] = block[kRowSize * r + kPointSize + c];
    }
  }
}

template <class S>
LinearOperator<Cpu>* BundleReducedSystem<S>::Factorize() {
  if (!context_.cholesky) return nullptr;
  FormBlocks();
  if (!factor_) factor_.emplace(context_.cholesky->MakeMatrix());
  CopyBlocks(context_.pattern, own_->blocks.data(), factor_->matrix());
  factor_->Factorize();
  return &*factor_;
}

template <class S>
std::string BundleReducedSystem<S>::factor_description() const {
  return context_.cholesky ? context_.cholesky->description() : "";
}

template class BundleReducedSystem<float>;
template class BundleReducedSystem<double>;

}  // namespace vesta::bundle::internal
