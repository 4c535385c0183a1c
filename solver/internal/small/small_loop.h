// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt for problems with few parameters: one problem, or a queue of problems, each in a SIMD lane.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#include "kernels/core/random.h"
#include "solver/internal/lm_decisions.h"
#include "solver/internal/normal_equations/raised_diagonal.h"
#include "solver/internal/small/small_system.h"
#include "solver/lm_options.h"
#include "solver/small_summary.h"

namespace vesta::small_internal {

// Throws Error if an option is out of range, or has no meaning for small problems.
void CheckSmallOptions(const LmOptions& options);

// Solves the problems of a Source, one per lane at a time. The lanes work in rounds: all lanes evaluate residuals and
// derivatives at a trial point, decide about it, and compute the next step. A lane that has finished takes the next
// problem. Lanes do not influence each other.
//
// Source has these functions. Next(lane, start) loads the next problem into a lane, writes its N start values, and
// returns false if no problem is left. functor(p, r) evaluates the problems of all lanes. Finish(lane, x, summary)
// takes the result.
template <class Rows, class Source>
class SmallLoop {
  static constexpr int N = Rows::kParameters;
  using V = typename Rows::V;
  using S = NumberOf<V>;
  static constexpr int kWidth = kLanes<V>;

 public:
  // All arguments must outlive this object.
  SmallLoop(const LmOptions& options, Source& source, Rows& rows)
      : options_(options),
        source_(source),
        rows_(rows),
        fresh_(options, CostRounding<S>()),
        has_time_limit_(std::isfinite(options.max_seconds)),
        lanes_(Lanes(fresh_, std::make_index_sequence<static_cast<std::size_t>(kWidth)>())) {}

  void Run() {
    for (int c = 0; c < N; ++c) at_x_.x[c] = step_[c] = at_trial_.x[c] = unit_[c] = damping_[c] = V(0);
    for (int lane = 0; lane < kWidth; ++lane) Load(lane);
    while (running_ > 0) {
      defined_ = rows_.Evaluate([&](auto* p, auto* r) { return source_.functor(p, r); }, at_trial_.x);
      Accumulate(rows_, at_trial_);
      Measure();
      for (int lane = 0; lane < kWidth; ++lane) {
        taken_[lane] = 0;
        if (lanes_[static_cast<std::size_t>(lane)].phase != Phase::kIdle) Decide(lane);
      }
      TakeTrials();
      Solve();
      for (int lane = 0; lane < kWidth; ++lane) {
        Lane& state = lanes_[static_cast<std::size_t>(lane)];
        if (state.phase == Phase::kStart) state.phase = Phase::kTrial;
        if (state.phase == Phase::kDone) Unload(lane);
      }
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  enum class Phase {
    kIdle,   // no problem
    kStart,  // the trial point is the start
    kTrial,
    kDone,
  };
  struct Lane {
    Phase phase = Phase::kIdle;
    LmDecisions decisions;
    SmallSummary summary = {};
    Clock::time_point start = {};
    bool solved = true;  // whether the step is finite
  };
  template <std::size_t... i>
  static std::array<Lane, kWidth> Lanes(const LmDecisions& fresh, std::index_sequence<i...>) {
    return {{(static_cast<void>(i), Lane{.decisions = fresh})...}};
  }

  void Load(int lane) {
    Lane& state = lanes_[static_cast<std::size_t>(lane)];
    S start[N];
    if (!source_.Next(lane, &start[0])) {
      state.phase = Phase::kIdle;
      return;
    }
    for (int c = 0; c < N; ++c) Entry(at_trial_.x[c], lane) = start[c];
    state.phase = Phase::kStart;
    state.decisions = fresh_;
    state.summary = {};
    if (has_time_limit_) state.start = Clock::now();
    ++running_;
  }

  void Unload(int lane) {
    S x[N];
    for (int c = 0; c < N; ++c) x[c] = Entry(at_x_.x[c], lane);
    source_.Finish(lane, &x[0], lanes_[static_cast<std::size_t>(lane)].summary);
    --running_;
    Load(lane);
  }

  // Computes the quantities that the decisions need, in all lanes.
  void Measure() {
    V gradient(0), diagonal(0), sum(0), x_norm(0), step_norm(0), slope(0), damped(0);
    for (int c = 0; c < N; ++c) {
      using std::abs;
      const V g = abs(at_trial_.g[c]);
      gradient = Max(gradient, g);
      sum += g;
      diagonal += at_trial_.h[PackedLower(c, c)];
      x_norm += at_x_.x[c] * at_x_.x[c];
      step_norm += step_[c] * step_[c];
      slope += at_x_.g[c] * step_[c];
      damped += damping_[c] * step_[c] * step_[c];
    }
    using std::sqrt;
    gradient_ = gradient, gradient_sum_ = sum, diagonal_sum_ = diagonal;
    x_norm_ = sqrt(x_norm), step_norm_ = sqrt(step_norm);
    // -g^T step - 1/2 step^T H step, where (H + damping) step = -g.
    predicted_ = V(0.5) * (damped - slope);
  }

  // Decides about the trial point of a lane.
  void Decide(int lane) {
    Lane& state = lanes_[static_cast<std::size_t>(lane)];
    const double cost = LaneTraits<V>::At(defined_, lane) ? static_cast<double>(Entry(at_trial_.cost, lane))
                                                          : std::numeric_limits<double>::quiet_NaN();
    if (state.phase == Phase::kStart) {
      state.decisions.Start(cost);
      state.summary.initial_cost = state.summary.final_cost = cost;
      taken_[lane] = 1;
      if (!std::isfinite(cost)) return Stop(state, LmStatus::kNonFinite);
      SetUnit(lane);
      if (TestPoint(lane)) TestLimits(state);
      return;
    }
    LmTrial trial = state.decisions.Judge(cost, static_cast<double>(Entry(predicted_, lane)));
    if (trial.zone != LmTrial::Zone::kCost) {
      trial.DecideByGradient(Fault(lane) == LmStatus::kRunning, SquaredGradient(at_trial_, lane),
                             SquaredGradient(at_x_, lane));
    }
    const LmVerdict verdict = state.decisions.Finish(trial, static_cast<double>(Entry(step_norm_, lane)),
                                                     static_cast<double>(Entry(x_norm_, lane)), state.solved);
    taken_[lane] = trial.accepted ? 1 : 0;
    ++(trial.accepted ? state.summary.num_accepted : state.summary.num_rejected);
    state.summary.final_cost = state.decisions.cost();
    if (verdict.ends()) return Stop(state, verdict.status());
    if (TestLimits(state) && trial.accepted) TestPoint(lane);
  }

  void Stop(Lane& state, LmStatus status) {
    state.summary.status = status;
    state.phase = Phase::kDone;
  }
  // Returns false if the solve ended.
  bool TestLimits(Lane& state) {
    if (state.summary.num_accepted + state.summary.num_rejected >= options_.max_iterations) {
      Stop(state, LmStatus::kMaxIterations);
    } else if (has_time_limit_ &&
               std::chrono::duration<double>(Clock::now() - state.start).count() >= options_.max_seconds) {
      Stop(state, LmStatus::kTimeLimit);
    }
    return state.phase != Phase::kDone;
  }
  // The status for derivatives that are not finite at the trial point, or kRunning.
  LmStatus Fault(int lane) const {
    if (!std::isfinite(Entry(gradient_sum_, lane))) return LmStatus::kNonFinite;
    return std::isfinite(Entry(diagonal_sum_, lane)) ? LmStatus::kRunning : LmStatus::kBadDiagonal;
  }
  // Tests the derivatives at a trial point that was taken. Returns false if the solve ended.
  bool TestPoint(int lane) {
    Lane& state = lanes_[static_cast<std::size_t>(lane)];
    if (const LmStatus fault = Fault(lane); fault != LmStatus::kRunning) {
      Stop(state, fault);
    } else {
      state.summary.gradient_max_norm = static_cast<double>(Entry(gradient_, lane));
      if (state.summary.gradient_max_norm <= options_.gradient_tolerance) Stop(state, LmStatus::kGradientTolerance);
    }
    return state.phase != Phase::kDone;
  }
  // sum_k g_k^2 / D_k, with the D of x.
  double SquaredGradient(const SmallSystem<V, N>& system, int lane) const {
    double sum = 0;
    for (int c = 0; c < N; ++c) {
      const auto g = static_cast<double>(Entry(system.g[c], lane));
      sum += g * g / static_cast<double>(Entry(metric_[c], lane));
    }
    return sum;
  }

  // Sets the units 1 / S^2 of the bounds of D from the diagonal of H at the start (ColumnScaling).
  void SetUnit(int lane) {
    S diagonal[N], scratch[N];
    for (int c = 0; c < N; ++c) diagonal[c] = Entry(at_trial_.h[PackedLower(c, c)], lane);
    const S largest = *std::max_element(diagonal, diagonal + N), least = *std::min_element(diagonal, diagonal + N);
    const auto is_regular = [&] { return static_cast<double>(least) > TinyDiagonal(static_cast<double>(largest)); };
    switch (options_.column_scaling) {
      case ColumnScaling::kNone:
        for (S& value : diagonal) value = 1;
        break;
      case ColumnScaling::kOnePlusInverse:
        for (S& value : diagonal) value = (1 + std::sqrt(value)) * (1 + std::sqrt(value));
        break;
      case ColumnScaling::kInverseRoot:
        if (is_regular()) break;
        if (largest > 0) {
          RaiseDiagonal<S>(std::span<S>(diagonal), static_cast<double>(largest), std::span<S>(scratch),
                           [&](std::span<S> shares) { SharesOfRows(lane, shares.data()); });
        } else {
          for (S& value : diagonal) value = 1;
        }
    }
    for (int c = 0; c < N; ++c) Entry(unit_[c], lane) = diagonal[c];
  }
  // shares[k] = sum over the rows i of J_ik / (J v)_i, with a random v, as in RaiseRoundingColumns.
  void SharesOfRows(int lane, S* shares) {
    CounterRandom random(1, 0);
    S v[N];
    for (S& value : v) value = static_cast<S>(0.5 + random.Uniform());
    std::fill_n(shares, N, S(0));
    for (int k = 0; k < rows_.rows(); ++k) {
      S product = 0;
      for (int c = 0; c < N; ++c) product += Entry(rows_.derivative(k, c), lane) * v[c];
      if (product == 0) continue;
      for (int c = 0; c < N; ++c) shares[c] += Entry(rows_.derivative(k, c), lane) / product;
    }
  }

  // Moves x to the trial point in the lanes that took it.
  void TakeTrials() {
    if constexpr (kWidth == 1) {
      if (taken_[0] != 0) at_x_ = at_trial_;
    } else {
      V taken(0);
      for (int lane = 0; lane < kWidth; ++lane) Entry(taken, lane) = taken_[lane];
      const auto mask = taken > V(0);
      const auto take = [&](V& to, const V& from) { to = Select(mask, from, to); };
      for (int c = 0; c < N; ++c) take(at_x_.x[c], at_trial_.x[c]);
      for (int c = 0; c < N; ++c) take(at_x_.g[c], at_trial_.g[c]);
      for (int c = 0; c < PackedSize(N); ++c) take(at_x_.h[c], at_trial_.h[c]);
    }
  }

  // Computes the steps and the next trial points.
  void Solve() {
    V lambda(0);
    for (int lane = 0; lane < kWidth; ++lane)
      Entry(lambda, lane) = static_cast<S>(lanes_[static_cast<std::size_t>(lane)].decisions.lambda());
    const V lowest(static_cast<S>(options_.normal_system.metric.min_diagonal));
    const V highest(static_cast<S>(options_.normal_system.metric.max_diagonal));
    for (int c = 0; c < N; ++c) {
      metric_[c] = Min(Max(at_x_.h[PackedLower(c, c)], lowest * unit_[c]), highest * unit_[c]);
      damping_[c] = lambda * metric_[c];
    }
    const auto accurate = SolveNormalEquations(at_x_, &damping_[0], &step_[0]);
    bool evaluated = false;  // whether rows_ was evaluated at x again
    for (int lane = 0; lane < kWidth; ++lane) {
      Lane& state = lanes_[static_cast<std::size_t>(lane)];
      state.solved = true;
      if (LaneTraits<V>::At(accurate, lane) || state.phase == Phase::kIdle || state.phase == Phase::kDone) continue;
      if (taken_[lane] == 0 && !evaluated) {
        rows_.Evaluate([&](auto* p, auto* r) { return source_.functor(p, r); }, at_x_.x);
        evaluated = true;
      }
      RefineStep(lane);
    }
    for (int c = 0; c < N; ++c) at_trial_.x[c] = at_x_.x[c] + step_[c];
  }
  void RefineStep(int lane) {
    S damping[N], step[N];
    for (int c = 0; c < N; ++c) damping[c] = Entry(damping_[c], lane);
    SolveByRotations(rows_, lane, &damping[0], &step[0]);
    lanes_[static_cast<std::size_t>(lane)].solved =
        std::all_of(step, step + N, [](S value) { return std::isfinite(value); });
    for (int c = 0; c < N; ++c) Entry(step_[c], lane) = lanes_[static_cast<std::size_t>(lane)].solved ? step[c] : S(0);
  }

  const LmOptions& options_;
  Source& source_;
  Rows& rows_;
  const LmDecisions fresh_;  // the state at the start
  const bool has_time_limit_;
  std::array<Lane, kWidth> lanes_;
  int running_ = 0;
  double taken_[kWidth] = {};  // 1 if the trial point becomes x, else 0
  SmallSystem<V, N> at_x_, at_trial_;
  MaskOf<V> defined_;
  V gradient_, gradient_sum_, diagonal_sum_, x_norm_, step_norm_, predicted_;  // set by Measure
  V unit_[N], metric_[N], damping_[N], step_[N];
};

}  // namespace vesta::small_internal
