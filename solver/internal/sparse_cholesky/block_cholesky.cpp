// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/block_cholesky.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/parallel.h"
#include "solver/internal/linear/small_dense.h"
#include "solver/internal/sparse_cholesky/front_kernels.h"

namespace vesta {
namespace {

// Columns per parallel task within one front; a multiple of kFrontStrip and of kFrontPad.
constexpr Index kTaskColumns = 48;

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Zeroes the lower triangle and the values above it that kernels access.
void ClearLower(double* values, Index stride, Index columns) {
  for (Index col = 0; col < columns; ++col) {
    const Index begin = std::max<Index>(col - kFrontStrip + 1, 0) / kFrontPad * kFrontPad;
    std::fill_n(values + col * stride + begin, stride - begin, 0.0);
  }
}

// Adds `count` values of `from` to `to`.
inline void AddRun(const double* from, Index count, double* to) {
  small_dense::WithSize(static_cast<int>(count), [&](auto n) {
    for (int i = 0; i < n; ++i) to[i] += from[i];
  });
}

// The same for several columns.
inline void AddRuns(const double* from, Index from_stride, Index count, Index columns, double* to, Index to_stride) {
  small_dense::WithSize(static_cast<int>(count), [&](auto n) {
    for (Index col = 0; col < columns; ++col) {
      for (int i = 0; i < n; ++i) to[col * to_stride + i] += from[col * from_stride + i];
    }
  });
}

}  // namespace

// Takes the smallest buffer that is large enough, or else the largest one.
HostBuffer<double> BlockCholesky::Pool::Acquire(Index size) {
  const std::lock_guard lock(mutex_);
  auto best = free_.end();
  for (auto it = free_.begin(); it != free_.end(); ++it) {
    const bool fits = it->capacity() >= size;
    if (best == free_.end() ||
        (fits ? best->capacity() < size || it->capacity() < best->capacity() : it->capacity() > best->capacity())) {
      best = it;
    }
  }
  HostBuffer<double> values;
  if (best != free_.end()) {
    values = std::move(*best);
    free_.erase(best);
  }
  values.ResizeForOverwrite(size);
  return values;
}

void BlockCholesky::Pool::Release(HostBuffer<double> values) {
  const std::lock_guard lock(mutex_);
  free_.push_back(std::move(values));
}

BlockCholesky::BlockCholesky(std::shared_ptr<const EliminationPlan> plan)
    : plan_(std::move(plan)), kernels_(FrontKernelsFor(ActiveIsa())) {
  Index total = 0, largest = 0;
  for (const EliminationFront& front : plan_->fronts) {
    first_value_.push_back(total);
    total += PaddedRows(front.scalars) * front.pivot_scalars;
    largest = std::max(largest, front.scalars);
  }
  values_.ResizeForOverwrite(total);  // Assemble clears it
  updates_.resize(plan_->fronts.size());
  assembled_.resize(plan_->fronts.size());
  least_.Resize(plan_->num_scalars);
  permuted_.Resize(plan_->num_scalars);
  local_.Resize(largest);
}

double BlockCholesky::Bytes(const EliminationPlan& plan) {
  double values = 0;
  for (const EliminationFront& front : plan.fronts) {
    values += static_cast<double>(PaddedRows(front.scalars)) * static_cast<double>(front.pivot_scalars);
  }
  return values * sizeof(double);
}

FrontPanel BlockCholesky::PanelOf(Index f) {
  const EliminationFront& front = plan_->fronts[At(f)];
  return {values_.data() + first_value_[At(f)], PaddedRows(front.scalars), front.scalars, front.pivot_scalars};
}

Index BlockCholesky::Factorize(const BlockMatrix& matrix, double scale, HostSpan<const double> added) {
  VESTA_CHECK(matrix.size() == permuted_.size() && added.size() == permuted_.size(),
              "a matrix of {} rows and a diagonal of {} for a plan of {}", matrix.size(), added.size(),
              permuted_.size());
  const Input input{matrix, scale, added};
  std::fill(assembled_.begin(), assembled_.end(), char{0});
  Index raised = 0;
  for (const EliminationWave& wave : plan_->waves) {
    raised += ParallelSum<Index>(wave.end - wave.begin, 1, [&](Index begin, Index end) {
      Index count = 0;
      for (Index t = begin; t < end; ++t) count += FactorizeSubtree(plan_->subtrees[At(wave.begin + t)], input);
      return count;
    });
    for (Index t = wave.begin; t < wave.end; ++t) {
      const Index root = plan_->subtrees[At(t)].end - 1;
      if (plan_->fronts[At(root)].parent >= 0) AddToParent(root, input);
    }
  }
  for (const std::vector<Index>& level : plan_->levels) {
    raised += ParallelSum<Index>(static_cast<Index>(level.size()), 1, [&](Index begin, Index end) {
      Index count = 0;
      for (Index k = begin; k < end; ++k) {
        // The updates of children in subtrees have been added already.
        for (const Index child : plan_->fronts[At(level[At(k)])].children) {
          if (!updates_[At(child)].empty()) AddToParent(child, input);
        }
        count += FactorizeFront(level[At(k)], input, true);
      }
      return count;
    });
  }
  return raised;
}

Index BlockCholesky::FactorizeSubtree(const EliminationSubtree& subtree, const Input& input) {
  Index raised = 0;
  for (Index f = subtree.begin; f < subtree.end; ++f) {
    raised += FactorizeFront(f, input, false);
    if (f + 1 < subtree.end) AddToParent(f, input);
  }
  return raised;
}

void BlockCholesky::Assemble(Index f, const Input& input) {
  if (std::exchange(assembled_[At(f)], char{1}) != 0) return;
  const EliminationFront& front = plan_->fronts[At(f)];
  const FrontPanel panel = PanelOf(f);
  ClearLower(panel.values, panel.stride, panel.pivots);
  for (const EliminationFront::Entry& entry : front.entries) {
    const double* source = entry.diagonal ? input.matrix.diagonal(entry.source) : input.matrix.block(entry.source);
    double* target = panel.values + entry.col * panel.stride + entry.row;
    const Index by_row = entry.transposed ? 1 : entry.cols, by_col = entry.transposed ? entry.rows : 1;
    small_dense::WithSize(entry.rows, [&](auto rows) {
      for (Index col = 0; col < entry.cols; ++col) {
        for (Index row = 0; row < rows; ++row) {
          target[col * panel.stride + row] = source[row * by_row + col * by_col];
        }
      }
    });
    if (!entry.diagonal) continue;
    const double* more = input.added.data() + input.matrix.pattern().offset(entry.source);
    for (Index col = 0; col < entry.cols; ++col) {
      double& pivot = target[col * panel.stride + col];
      pivot += input.scale * more[col];
      least_[front.first_scalar + entry.col + col] = 1e-13 * pivot;
    }
  }
  const Index below = panel.rows - panel.pivots, stride = PaddedRows(below);
  if (below == 0) return;
  updates_[At(f)] = pool_.Acquire(stride * below);
  // Without children, FactorizeFront writes the first values.
  if (!front.children.empty()) ClearLower(updates_[At(f)].data(), stride, below);
}

Index BlockCholesky::FactorizeFront(Index f, const Input& input, bool parallel) {
  Assemble(f, input);
  const EliminationFront& front = plan_->fronts[At(f)];
  const FrontPanel panel = PanelOf(f);
  const Index raised = FactorizePanel(panel, least_.data() + front.first_scalar, parallel);
  const Index below = panel.rows - panel.pivots;
  const auto add_outer = front.children.empty() ? kernels_.negative_outer : kernels_.subtract_outer;
  ParallelForChunks(below, parallel ? kTaskColumns : std::max<Index>(below, 1), [&](Index begin, Index end) {
    add_outer(panel, updates_[At(f)].data(), PaddedRows(below), begin, end);
  });
  return raised;
}

Index BlockCholesky::FactorizePanel(const FrontPanel& panel, const double* least, bool parallel) const {
  if (!parallel) return kernels_.factorize(panel, least);
  // Factorise a few columns at a time, then update the later ones.
  Index raised = 0;
  for (Index first = 0; first < panel.pivots; first += kTaskColumns) {
    const Index columns = std::min(kTaskColumns, panel.pivots - first);
    const FrontPanel part = {panel.values + first * (panel.stride + 1), panel.stride, panel.rows - first, columns};
    raised += kernels_.factorize(part, least + first);
    ParallelForChunks(panel.pivots - first - columns, kTaskColumns, [&](Index begin, Index end) {
      kernels_.subtract_outer(part, part.values + columns * (panel.stride + 1), panel.stride, begin, end);
    });
  }
  return raised;
}

void BlockCholesky::AddToParent(Index f, const Input& input) {
  const EliminationFront& child = plan_->fronts[At(f)];
  Assemble(child.parent, input);
  const FrontPanel panel = PanelOf(child.parent);
  double* const parent_update = updates_[At(child.parent)].data();
  HostBuffer<double> waiting = std::exchange(updates_[At(f)], {});
  const double* const update = waiting.data();
  const Index stride = PaddedRows(child.scalars - child.pivot_scalars);
  const Index parent_stride = PaddedRows(panel.rows - panel.pivots);
  const std::vector<EliminationFront::Run>& runs = child.runs_in_parent;
  for (auto of_cols = runs.begin(); of_cols != runs.end(); ++of_cols) {
    // A run of columns may begin at the parent's pivots and end below them.
    for (Index begin = of_cols->begin, end; begin < of_cols->end; begin = end) {
      const Index to_col = of_cols->to + begin - of_cols->begin;
      const bool is_pivot = to_col < panel.pivots;
      end = is_pivot ? std::min(of_cols->end, begin + panel.pivots - to_col) : of_cols->end;
      const Index to_stride = is_pivot ? panel.stride : parent_stride;
      double* to = is_pivot ? panel.values + to_col * to_stride
                            : parent_update + (to_col - panel.pivots) * to_stride - panel.pivots;
      const double* from = update + begin * stride;
      for (Index col = begin; col < end; ++col) {
        const Index below = col - begin;
        AddRun(from + below * stride + col, of_cols->end - col, to + below * to_stride + to_col + below);
      }
      for (auto of_rows = of_cols + 1; of_rows != runs.end(); ++of_rows) {
        AddRuns(from + of_rows->begin, stride, of_rows->end - of_rows->begin, end - begin, to + of_rows->to, to_stride);
      }
    }
  }
  pool_.Release(std::move(waiting));
}

void BlockCholesky::Solve(HostSpan<const double> x, HostSpan<double> y) {
  for (const EliminationPlan::Row& row : plan_->order) {
    std::copy_n(x.data() + row.source, row.size, permuted_.data() + row.position);
  }
  const Index count = static_cast<Index>(plan_->fronts.size());
  for (Index f = 0; f < count; ++f) {
    const EliminationFront& front = plan_->fronts[At(f)];
    const FrontPanel panel = PanelOf(f);
    double* pivots = permuted_.data() + front.first_scalar;
    std::copy_n(pivots, panel.pivots, local_.data());
    std::fill_n(local_.data() + panel.pivots, panel.rows - panel.pivots, 0.0);
    kernels_.forward(panel, local_.data());
    std::copy_n(local_.data(), panel.pivots, pivots);
    const double* change = local_.data() + panel.pivots;
    for (const auto& [begin, end, to] : front.runs_in_order) AddRun(change + begin, end - begin, permuted_.data() + to);
  }
  for (Index f = count; f-- > 0;) {
    const EliminationFront& front = plan_->fronts[At(f)];
    const FrontPanel panel = PanelOf(f);
    double* pivots = permuted_.data() + front.first_scalar;
    std::copy_n(pivots, panel.pivots, local_.data());
    double* below = local_.data() + panel.pivots;
    for (const auto& [begin, end, to] : front.runs_in_order) {
      std::copy_n(permuted_.data() + to, end - begin, below + begin);
    }
    kernels_.backward(panel, local_.data());
    std::copy_n(local_.data(), panel.pivots, pivots);
  }
  for (const EliminationPlan::Row& row : plan_->order) {
    std::copy_n(permuted_.data() + row.position, row.size, y.data() + row.source);
  }
}

std::shared_ptr<SparseCholesky> SparseCholesky::Plan(const BlockPattern& pattern, double max_bytes,
                                                     double max_multiplications, ExceededLimit* exceeded) {
  ExceededLimit found = ExceededLimit::kNone;
  std::optional<EliminationPlan> plan = PlanElimination(
      pattern, {.factor_values = max_bytes / sizeof(double), .multiplications = max_multiplications}, &found);
  // Merged fronts store more values, with padded rows.
  if (plan && BlockCholesky::Bytes(*plan) > max_bytes) {
    found = ExceededLimit::kFactorValues;
  } else if (plan && plan->multiplications > max_multiplications) {
    found = ExceededLimit::kMultiplications;
  }
  if (exceeded) *exceeded = found;
  if (found != ExceededLimit::kNone) return nullptr;
  return std::shared_ptr<SparseCholesky>(new SparseCholesky(std::move(*plan)));
}

std::shared_ptr<SparseCholesky> SparseCholesky::ForPattern(const BlockPattern& planned,
                                                           const BlockPattern& other) const {
  const int from = planned.uniform_size(), to = other.uniform_size();
  if (from == 0 || to == 0 || !planned.HasSamePlaces(other)) return nullptr;
  return std::shared_ptr<SparseCholesky>(new SparseCholesky(Resized(*plan_, from, to)));
}

std::string SparseCholesky::description() const {
  return fmt::format("{} of {:.1f} MiB", ToString(PreconditionerKind::kSparseCholesky), bytes() / 0x1p20);
}

SparseCholeskyPreconditioner::SparseCholeskyPreconditioner(std::shared_ptr<SparseCholesky> cholesky, std::string why)
    : cholesky_(std::move(cholesky)), why_(std::move(why)) {}

void SparseCholeskyPreconditioner::SetLinearization(std::span<LinearizationAdaptor<B>* const> batches,
                                                    B::ConstVectorView /*diag_h*/) {
  VESTA_CHECK(batches.size() == 1, "a sparse Cholesky factor is of one batch, not of {}", batches.size());
  source_ = dynamic_cast<NormalMatrixSource*>(&batches.front()->get());
  VESTA_CHECK(source_ != nullptr, "this preconditioner needs linearizations of its own problem");
  if (!plan_) return;
  factor_.reset();
  cholesky_ = plan_(source_->NormalMatrix().pattern());
}

void SparseCholeskyPreconditioner::SetDamping(double lambda, B::ConstVectorView metric) {
  VESTA_CHECK(source_ != nullptr, "SetLinearization comes before SetDamping");
  if (!factor_) factor_ = cholesky_->Factor();
  num_raised_ = factor_->Factorize(source_->NormalMatrix(), lambda, metric);
}

std::string SparseCholeskyPreconditioner::description() const {
  if (!cholesky_) return ToString(PreconditionerKind::kSparseCholesky);
  return cholesky_->description() + why_;
}

VESTA_DECLARE_PER_ISA(const FrontKernels& CompiledFrontKernels();)

const FrontKernels& FrontKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledFrontKernels)(); }

}  // namespace vesta
