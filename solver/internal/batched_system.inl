// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/batched_system.h.
#pragma once

#include <algorithm>
#include <numeric>
#include <utility>

#include "solver/internal/batched_system.h"
#include "solver/internal/normal_equations/rounding_columns.inl"

namespace vesta {

template <Backend B>
BatchedSystem<B>::BatchedSystem(const LmOptions& options, B& backend, ProblemAdaptor<B> problem,
                                typename B::ConstVectorView x, double cost, ColumnScale<B>& scale, LmSummary& summary)
    : options_(options), backend_(backend), problem_(problem), x_(x), scale_(scale), summary_(summary) {
  const int batches = problem.num_batches();
  const int systems = options.batch_mode == BatchMode::kExact ? 1 : batches;
  if (systems > 1) {
    negative_gradient_.Resize(problem.num_tangent());
    diagonal_.Resize(problem.num_tangent());
  }
  summary.num_residuals = 0;
  for (int s = 0; s < systems; ++s) {
    auto system = MakeSystem(s, systems == 1 ? batches : 1);
    if (fault_.kind == SystemFault::Kind::kNone) fault_ = system->fault();
    if (fault_.kind == SystemFault::Kind::kNone && zero_column_gradient_.empty()) {
      zero_column_gradient_ = system->DescribeZeroColumn(
          x_, std::max(options.gradient_tolerance, UnderflowGradient<B>(system->num_residuals(), cost)));
    }
    if (systems > 1) {
      backend.Axpby(1.0, system->negative_gradient(), 1.0, negative_gradient_);
      backend.Axpby(1.0, system->diagonal(), 1.0, diagonal_);
    }
    summary.num_residuals += system->num_residuals();
    systems_.push_back(systems == 1 || options.hold_batches ? std::move(system) : nullptr);
  }
  if (fault_.kind != SystemFault::Kind::kNone) return;
  const typename B::ConstVectorView diagonal = whole() ? whole()->diagonal() : diagonal_.view();
  summary.num_zero_columns = whole() ? whole()->num_zero_columns() : backend.CountNonPositive(diagonal);
  if (scale_.square.empty()) scale_ = MakeScale(diagonal);
  for (auto& system : systems_) {
    if (!system) continue;
    Prepare(*system, systems > 1);
  }
}

template <Backend B>
ColumnScale<B> BatchedSystem<B>::MakeScale(typename B::ConstVectorView diagonal) {
  if (options_.column_scaling != ColumnScaling::kInverseRoot || !whole())
    return MakeColumnScale<B>(options_.column_scaling, backend_, diagonal);
  const typename B::Vector raised = RaiseRoundingColumns<B>(backend_, whole()->batches(), diagonal);
  return MakeColumnScale<B>(options_.column_scaling, backend_, raised.empty() ? diagonal : raised.view());
}

template <Backend B>
std::unique_ptr<NormalSystem<B>> BatchedSystem<B>::MakeSystem(int first, int count) {
  std::vector<int> batches(static_cast<std::size_t>(count));
  std::iota(batches.begin(), batches.end(), first);
  summary_.num_linearizations += count;
  return std::make_unique<NormalSystem<B>>(backend_, problem_, x_, batches);
}

template <Backend B>
NormalSystem<B>& BatchedSystem<B>::System(std::size_t batch, std::unique_ptr<NormalSystem<B>>& fresh) {
  if (systems_[batch]) return *systems_[batch];
  fresh.reset();  // keep only one batch's caches in memory
  fresh = MakeSystem(static_cast<int>(batch), 1);
  Prepare(*fresh, true);
  return *fresh;
}

template <Backend B>
void BatchedSystem<B>::Prepare(NormalSystem<B>& system, bool keep_diagonal) {
  const bool describe = summary_.linear_solver.empty();
  system.Prepare(options_.normal_system, x_, scale_, keep_diagonal, describe);
  if (describe) summary_.linear_solver = system.description();
}

template <Backend B>
typename BatchedSystem<B>::Direction BatchedSystem<B>::Solve(double lambda, PcgWorkspace<B>& workspace,
                                                             typename B::VectorView step) {
  Direction direction;
  if (whole()) {
    const auto solution = whole()->Solve(lambda, workspace, step);
    direction = {solution.pcg, solution.gradient_dot_step, solution.curvature};
  } else {
    direction = Merge(lambda, workspace, step);
  }
  summary_.num_pcg_iterations += direction.pcg.iterations;
  summary_.num_products += direction.pcg.products;
  return direction;
}

template <Backend B>
typename BatchedSystem<B>::Direction BatchedSystem<B>::Merge(double lambda, PcgWorkspace<B>& workspace,
                                                             typename B::VectorView step) {
  Direction direction;
  std::unique_ptr<NormalSystem<B>> fresh;
  int iterations = 0, products = 0;
  backend_.Fill(0, step);
  for (std::size_t b = 0; b < systems_.size(); ++b) {
    workspace.Release();  // creating a system or its preconditioner needs the most memory
    NormalSystem<B>& system = System(b, fresh);
    typename B::Vector batch_step(step.size());
    direction.pcg = system.Solve(lambda, workspace, batch_step).pcg;
    iterations += direction.pcg.iterations;
    products += direction.pcg.products;
    backend_.AddScaled(1.0, system.diagonal(), batch_step, step);
  }
  backend_.DivideOrZero(step, diagonal_, step);
  fresh.reset();  // Measure creates its own
  workspace.Release();
  Measure(step, direction);
  direction.pcg.iterations = iterations;
  direction.pcg.products = products + static_cast<int>(systems_.size());
  return direction;
}

template <Backend B>
void BatchedSystem<B>::Measure(typename B::ConstVectorView step, Direction& direction) {
  std::unique_ptr<NormalSystem<B>> fresh;
  direction.gradient_dot_step = -backend_.Dot(negative_gradient(), step);
  direction.curvature = 0;
  for (std::size_t b = 0; b < systems_.size(); ++b) direction.curvature += System(b, fresh).Curvature(step);
}

}  // namespace vesta
