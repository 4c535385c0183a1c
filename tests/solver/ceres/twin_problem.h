// SPDX-License-Identifier: Apache-2.0
// One problem in two forms, a ceres::Problem and a BlockProblem, for tests adapted from Ceres. It is solved by
// Ceres, by the bridge and natively.
#pragma once

#include <ceres/ceres.h>

#include <cstddef>
#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/block_problem.h"
#include "solver/ceres/ceres_solve.h"
#include "solver/cost_function.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::test {

// The same loss or manifold for both problems; both pointers may be null.
struct TwinLoss {
  std::shared_ptr<ceres::LossFunction> theirs = nullptr;
  std::shared_ptr<const Loss> ours = nullptr;
};
struct TwinManifold {
  std::shared_ptr<ceres::Manifold> theirs = nullptr;
  std::shared_ptr<const Manifold> ours = nullptr;
};

// Evaluate of a cost function with derivatives by hand.
using Evaluation = std::function<bool(const double* const* parameters, double* residuals, double** jacobians)>;

class TheirFunction final : public ceres::CostFunction {
 public:
  TheirFunction(int num_residuals, const std::vector<int>& sizes, Evaluation evaluate)
      : evaluate_(std::move(evaluate)) {
    set_num_residuals(num_residuals);
    *mutable_parameter_block_sizes() = sizes;
  }
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    return evaluate_(parameters, residuals, jacobians);
  }

 private:
  Evaluation evaluate_;
};

class OurFunction final : public CostFunction {
 public:
  OurFunction(int num_residuals, const std::vector<int>& sizes, Evaluation evaluate)
      : CostFunction(num_residuals, sizes), evaluate_(std::move(evaluate)) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    return evaluate_(parameters, residuals, jacobians);
  }

 private:
  Evaluation evaluate_;
};

// kDefaults: natively with vesta's own linear solver and column scaling. kNative: natively with FromCeres(options).
enum class Way { kCeres, kBridge, kNative, kDefaults };
inline constexpr Way kOurWays[] = {Way::kBridge, Way::kNative, Way::kDefaults};
inline const char* ToString(Way way) {
  constexpr const char* kNames[] = {"Ceres", "bridge", "native", "native, default options"};
  return kNames[static_cast<int>(way)];
}

struct Solved {
  bool converged = false;
  double initial_cost = 0, final_cost = 0, fixed_cost = 0;
  std::size_t num_iterations = 0;  // without the start
  std::vector<double> x;           // all blocks, in the order in which they were added
  std::string report;
};

// Options of ceres::Solve that print nothing.
inline ceres::Solver::Options Quiet(ceres::LinearSolverType linear_solver = ceres::DENSE_QR) {
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.linear_solver_type = linear_solver;
  return options;
}
// Converges to rounding.
inline ceres::Solver::Options Tolerances(double tolerance, ceres::Solver::Options options = Quiet()) {
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = tolerance;
  return options;
}

inline CpuBackend<double>::ConstVectorView View(const std::vector<double>& x) {
  return {x.data(), static_cast<Index>(x.size())};
}

class TwinProblem {
 public:
  explicit TwinProblem(ceres::EvaluationCallback* callback = nullptr, BlockProblem::Options ours = {})
      : callback_(callback), theirs_(OptionsOf(callback)), ours_(std::move(ours)) {}

  // Returns the index of the block in both problems.
  int AddBlock(std::vector<double> start, const TwinManifold& manifold = {}) {
    starts_.push_back(std::move(start));
    values_.push_back(starts_.back());
    const int size = static_cast<int>(starts_.back().size());
    theirs_.AddParameterBlock(values_.back().data(), size);
    const int block = ours_.AddParameterBlock(size);
    SetManifold(block, manifold);
    return block;
  }
  void SetManifold(int block, const TwinManifold& manifold) {
    manifolds_.push_back(manifold.theirs);
    theirs_.SetManifold(values(block), manifold.theirs.get());
    ours_.SetManifold(block, manifold.ours);
  }
  void SetConstant(int block, bool constant = true) {
    constant ? theirs_.SetParameterBlockConstant(values(block)) : theirs_.SetParameterBlockVariable(values(block));
    ours_.SetConstant(block, constant);
  }
  void SetBounds(int block, int entry, double lower, double upper) {
    theirs_.SetParameterLowerBound(values(block), entry, lower);
    theirs_.SetParameterUpperBound(values(block), entry, upper);
    ours_.SetBounds(block, entry, lower, upper);
  }

  // Adds a residual block with automatic derivatives; returns Ceres's id of it.
  template <int kResiduals, int... kSizes, class F>
  ceres::ResidualBlockId Add(const F& functor, const std::vector<int>& blocks, const TwinLoss& loss = {}) {
    return Add(std::make_shared<ceres::AutoDiffCostFunction<F, kResiduals, kSizes...>>(new F(functor)),
               std::make_shared<AutoDiffCost<F, kResiduals, kSizes...>>(functor), blocks, loss);
  }
  // Adds a residual block with derivatives by hand.
  ceres::ResidualBlockId Add(int num_residuals, const Evaluation& evaluate, const std::vector<int>& blocks,
                             const TwinLoss& loss = {}) {
    std::vector<int> sizes;
    sizes.reserve(blocks.size());
    for (const int block : blocks) sizes.push_back(ours_.parameter_block_size(block));
    return Add(std::make_shared<TheirFunction>(num_residuals, sizes, evaluate),
               std::make_shared<OurFunction>(num_residuals, sizes, evaluate), blocks, loss);
  }
  ceres::ResidualBlockId Add(std::shared_ptr<ceres::CostFunction> theirs, std::shared_ptr<const CostFunction> ours,
                             const std::vector<int>& blocks, const TwinLoss& loss = {}) {
    std::vector<double*> arguments;
    arguments.reserve(blocks.size());
    for (const int block : blocks) arguments.push_back(values(block));
    ours_.AddResidualBlock(std::move(ours), loss.ours, std::span<const int>(blocks));
    costs_.push_back(std::move(theirs));
    losses_.push_back(loss.theirs);
    return theirs_.AddResidualBlock(costs_.back().get(), loss.theirs.get(), arguments);
  }

  ceres::Problem& theirs() { return theirs_; }
  BlockProblem& ours() { return ours_; }
  // The block's values in the ceres::Problem.
  double* values(int block) { return values_.at(static_cast<std::size_t>(block)).data(); }
  int num_blocks() const { return static_cast<int>(values_.size()); }
  // The values of all blocks, one after another.
  std::vector<double> x() const {
    std::vector<double> all;
    for (const std::vector<double>& block : values_) all.insert(all.end(), block.begin(), block.end());
    return all;
  }

  // Solves from the start.
  Solved Solve(Way way, const ceres::Solver::Options& options) {
    for (std::size_t b = 0; b < values_.size(); ++b)
      std::copy(starts_[b].begin(), starts_[b].end(), values_[b].begin());
    if (way == Way::kCeres) {
      ceres::Solver::Summary summary;
      ceres::Solve(options, &theirs_, &summary);
      return {.converged = summary.termination_type == ceres::CONVERGENCE,
              .initial_cost = summary.initial_cost,
              .final_cost = summary.final_cost,
              .fixed_cost = summary.fixed_cost,
              .num_iterations = summary.iterations.empty() ? 0 : summary.iterations.size() - 1,
              .x = x(),
              .report = summary.FullReport()};
    }
    if (way == Way::kBridge) {
      const LmSummary summary = ceres_bridge::Solve(options, theirs_, {}, callback_);
      return From(summary, x());
    }
    LmOptions native = ceres_bridge::FromCeres(options);
    if (way == Way::kDefaults) native.normal_system = {}, native.column_scaling = LmOptions().column_scaling;
    std::vector<double> at = x();
    const LmSummary summary = SolveLm(ours_, at, native);
    return From(summary, at);
  }

 private:
  static ceres::Problem::Options OptionsOf(ceres::EvaluationCallback* callback) {
    ceres::Problem::Options options;
    options.cost_function_ownership = options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.evaluation_callback = callback;
    return options;
  }
  static Solved From(const LmSummary& summary, const std::vector<double>& x) {
    return {.converged = IsConverged(summary.status),
            .initial_cost = summary.initial_cost,
            .final_cost = summary.final_cost,
            .fixed_cost = summary.fixed_cost,
            .num_iterations = summary.iterations.empty() ? 0 : summary.iterations.size() - 1,
            .x = x,
            .report = summary.FullReport()};
  }

  std::deque<std::vector<double>> starts_, values_;
  std::vector<std::shared_ptr<ceres::CostFunction>> costs_;
  std::vector<std::shared_ptr<ceres::LossFunction>> losses_;
  std::vector<std::shared_ptr<ceres::Manifold>> manifolds_;
  ceres::EvaluationCallback* callback_;
  ceres::Problem theirs_;
  BlockProblem ours_;
};

}  // namespace vesta::test
