#include "problems/pose_graph/block_cholesky.h"

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::pose_graph {
namespace {

// Columns that one task of a front's own work takes; a multiple of 6 and of kFrontPad.
constexpr Index kTaskColumns = 48;

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Zeros for blocks of columns of d, from their diagonal blocks down.
void ClearLower(double* values, Index stride, Index columns, Index d) {
  for (Index col = 0; col < columns; ++col) {
    const Index begin = col / d * d / kFrontPad * kFrontPad;
    std::fill_n(values + col * stride + begin, stride - begin, 0.0);
  }
}

}  // namespace

// Takes the smallest that suffices, or the largest there is.
std::vector<double> BlockCholesky::Pool::Take(std::size_t size) {
  auto best = free_.end();
  for (auto it = free_.begin(); it != free_.end(); ++it) {
    const bool fits = it->capacity() >= size;
    if (best == free_.end() ||
        (fits ? best->capacity() < size || it->capacity() < best->capacity() : it->capacity() > best->capacity())) {
      best = it;
    }
  }
  std::vector<double> values;
  if (best != free_.end()) {
    values = std::move(*best);
    free_.erase(best);
  }
  if (values.size() < size) values.resize(size);
  return values;
}

BlockCholesky::BlockCholesky(std::shared_ptr<const EliminationPlan> plan, int block_size)
    : plan_(std::move(plan)), block_size_(block_size), kernels_(FrontKernelsFor(ActiveIsa())) {
  VESTA_CHECK(block_size == 3 || block_size == 6, "blocks of {} rows", block_size);
  Index total = 0, largest = 0;
  for (const EliminationFront& front : plan_->fronts) {
    first_value_.push_back(total);
    total += PaddedRows(front.rows() * block_size_) * front.pivots * block_size_;
    largest = std::max(largest, front.rows() * block_size_);
  }
  values_.Resize(total);
  updates_.resize(plan_->fronts.size());
  pool_of_front_.resize(plan_->fronts.size());
  std::size_t pool = 0;
  for (const EliminationSubtree& subtree : plan_->subtrees) {
    for (Index f = subtree.begin; f < subtree.end; ++f) pool_of_front_[At(f)] = pool;
    ++pool;
  }
  for (const auto& level : plan_->levels) {
    for (const Index f : level) pool_of_front_[At(f)] = pool++;
  }
  pools_.resize(pool);
  permuted_.Resize(static_cast<Index>(plan_->order.size()) * block_size_);
  local_.Resize(largest);
}

Panel BlockCholesky::PanelOf(Index f) {
  const EliminationFront& front = plan_->fronts[At(f)];
  const Index rows = front.rows() * block_size_;
  return {values_.data() + first_value_[At(f)], PaddedRows(rows), rows, front.pivots * block_size_};
}

Index BlockCholesky::Factorize(const BlockMatrix& matrix, double scale, HostSpan<const double> added) {
  VESTA_CHECK(
      matrix.size() == permuted_.size() && matrix.block_size() == block_size_ && added.size() == permuted_.size(),
      "a matrix of {} rows and a diagonal of {} for a plan of {}", matrix.size(), added.size(), permuted_.size());
  const auto subtrees = static_cast<Index>(plan_->subtrees.size());
  Index raised = ParallelSum<Index>(subtrees, 1, [&](Index begin, Index end) {
    Index sum = 0;
    for (Index t = begin; t < end; ++t) {
      for (Index f = plan_->subtrees[At(t)].begin; f < plan_->subtrees[At(t)].end; ++f) {
        sum += FactorizeFront(f, matrix, scale, added, false);
      }
    }
    return sum;
  });
  for (const std::vector<Index>& level : plan_->levels) {
    raised += ParallelSum<Index>(static_cast<Index>(level.size()), 1, [&](Index begin, Index end) {
      Index sum = 0;
      for (Index k = begin; k < end; ++k) sum += FactorizeFront(level[At(k)], matrix, scale, added, true);
      return sum;
    });
  }
  return raised;
}

Index BlockCholesky::FactorizeFront(Index f, const BlockMatrix& matrix, double scale, HostSpan<const double> added,
                                    bool parallel) {
  const EliminationFront& front = plan_->fronts[At(f)];
  const Panel panel = PanelOf(f);
  const Index d = block_size_;
  ClearLower(panel.values, panel.stride, panel.pivots, d);
  std::vector<double> least(At(panel.pivots));
  for (const EliminationFront::Entry& entry : front.entries) {
    const double* source = entry.diagonal ? matrix.diagonal(entry.source) : matrix.block(entry.source);
    double* target = panel.values + entry.col * d * panel.stride + entry.row * d;
    const Index by_row = entry.transposed ? 1 : d, by_col = entry.transposed ? d : 1;
    for (Index col = 0; col < d; ++col) {
      for (Index row = 0; row < d; ++row) target[col * panel.stride + row] = source[row * by_row + col * by_col];
      if (!entry.diagonal) continue;
      double& pivot = target[col * panel.stride + col];
      pivot += scale * added[entry.source * d + col];
      least[At(entry.col * d + col)] = 1e-13 * pivot;
    }
  }
  const Index below = panel.rows - panel.pivots, update_stride = PaddedRows(below);
  std::vector<double> update = pools_[pool_of_front_[At(f)]].Take(At(update_stride * below));
  ClearLower(update.data(), update_stride, below, d);
  for (const Index child : front.children) {
    std::vector<double>& child_update = updates_[At(child)];
    if (d == 3) {
      AddChild<3>(plan_->fronts[At(child)], child_update.data(), panel, update.data());
    } else {
      AddChild<6>(plan_->fronts[At(child)], child_update.data(), panel, update.data());
    }
    pools_[pool_of_front_[At(child)]].Give(std::move(child_update));
  }
  const Index raised = FactorizePanel(panel, least.data(), parallel);
  ParallelForChunks(below, parallel ? kTaskColumns : std::max<Index>(below, 1), [&](Index begin, Index end) {
    kernels_.subtract_outer(panel, update.data(), update_stride, begin, end);
  });
  if (front.parent < 0) {
    pools_[pool_of_front_[At(f)]].Give(std::move(update));
  } else {
    updates_[At(f)] = std::move(update);
  }
  return raised;
}

Index BlockCholesky::FactorizePanel(const Panel& panel, const double* least, bool parallel) const {
  if (!parallel) return kernels_.factorize(panel, least);
  // A few columns at a time, then their effect on the later ones.
  Index raised = 0;
  for (Index first = 0; first < panel.pivots; first += kTaskColumns) {
    const Index columns = std::min(kTaskColumns, panel.pivots - first);
    const Panel part = {panel.values + first * (panel.stride + 1), panel.stride, panel.rows - first, columns};
    raised += kernels_.factorize(part, least + first);
    ParallelForChunks(panel.pivots - first - columns, kTaskColumns, [&](Index begin, Index end) {
      kernels_.subtract_outer(part, part.values + columns * (panel.stride + 1), panel.stride, begin, end);
    });
  }
  return raised;
}

template <int D>
void BlockCholesky::AddChild(const EliminationFront& child, const double* update, const Panel& panel,
                             double* parent_update) const {
  const auto rows = static_cast<Index>(child.below.size());
  const Index stride = PaddedRows(rows * D), parent_stride = PaddedRows(panel.rows - panel.pivots);
  const Index* place = child.place_in_parent.data();
  for (Index col = 0; col < rows; ++col) {
    const Index to_col = place[col] * D;
    const bool is_pivot = to_col < panel.pivots;
    const Index to_stride = is_pivot ? panel.stride : parent_stride;
    double* to = is_pivot ? panel.values + to_col * panel.stride
                          : parent_update + (to_col - panel.pivots) * parent_stride - panel.pivots;
    for (int c = 0; c < D; ++c) {
      const double* from = update + (col * D + c) * stride;
      for (Index row = col; row < rows; ++row) {
        double* target = to + c * to_stride + place[row] * D;
        for (int r = 0; r < D; ++r) target[r] += from[row * D + r];
      }
    }
  }
}

void BlockCholesky::Solve(HostSpan<const double> x, HostSpan<double> y) {
  const Index d = block_size_;
  for (std::size_t k = 0; k < plan_->order.size(); ++k) {
    std::copy_n(x.data() + plan_->order[k] * d, d, permuted_.data() + static_cast<Index>(k) * d);
  }
  const Index count = static_cast<Index>(plan_->fronts.size());
  for (Index f = 0; f < count; ++f) {
    const EliminationFront& front = plan_->fronts[At(f)];
    const Panel panel = PanelOf(f);
    double* pivots = permuted_.data() + front.first * d;
    std::copy_n(pivots, panel.pivots, local_.data());
    std::fill_n(local_.data() + panel.pivots, panel.rows - panel.pivots, 0.0);
    kernels_.forward(panel, local_.data());
    std::copy_n(local_.data(), panel.pivots, pivots);
    const double* change = local_.data() + panel.pivots;
    for (const Index row : front.below) {
      for (Index c = 0; c < d; ++c) permuted_[row * d + c] += *change++;
    }
  }
  for (Index f = count; f-- > 0;) {
    const EliminationFront& front = plan_->fronts[At(f)];
    const Panel panel = PanelOf(f);
    double* pivots = permuted_.data() + front.first * d;
    std::copy_n(pivots, panel.pivots, local_.data());
    double* below = local_.data() + panel.pivots;
    for (const Index row : front.below) below = std::copy_n(permuted_.data() + row * d, d, below);
    kernels_.backward(panel, local_.data());
    std::copy_n(local_.data(), panel.pivots, pivots);
  }
  for (std::size_t k = 0; k < plan_->order.size(); ++k) {
    std::copy_n(permuted_.data() + static_cast<Index>(k) * d, d, y.data() + plan_->order[k] * d);
  }
}

}  // namespace vesta::pose_graph
