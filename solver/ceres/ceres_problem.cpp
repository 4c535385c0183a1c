// SPDX-License-Identifier: Apache-2.0
#include "solver/ceres/ceres_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "solver/bounds.h"

namespace vesta::ceres_bridge {

namespace {

class LossOf final : public Loss {
 public:
  explicit LossOf(const ceres::LossFunction& loss) : loss_(loss) {}
  Value Evaluate(double s) const override {
    double rho[3];
    loss_.Evaluate(s, rho);
    return {rho[0], rho[1], rho[2]};
  }

 private:
  const ceres::LossFunction& loss_;
};

class ManifoldOf final : public Manifold {
 public:
  explicit ManifoldOf(const ceres::Manifold& manifold) : manifold_(manifold) {}
  int ambient_size() const override { return manifold_.AmbientSize(); }
  int tangent_size() const override { return manifold_.TangentSize(); }
  void Plus(const double* x, const double* delta, double* out) const override {
    // Ceres does not guarantee that Plus works in place.
    std::vector<double> from(x, x + ambient_size());
    if (!manifold_.Plus(from.data(), delta, out)) {
      std::fill_n(out, ambient_size(), std::numeric_limits<double>::quiet_NaN());
    }
  }
  void PlusJacobian(const double* x, double* jacobian) const override {
    if (!manifold_.PlusJacobian(x, jacobian)) {
      std::fill_n(jacobian, ambient_size() * tangent_size(), std::numeric_limits<double>::quiet_NaN());
    }
  }

 private:
  const ceres::Manifold& manifold_;
};

}  // namespace

CeresProblem::Cost::Cost(const ceres::CostFunction& cost)
    : CostFunction(cost.num_residuals(), std::span<const int>(cost.parameter_block_sizes())), cost_(cost) {}

bool CeresProblem::Cost::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  return cost_.Evaluate(parameters, residuals, jacobians);
}

CeresProblem::CeresProblem(ceres::Problem& problem, BlockProblem::Options options) : problem_(std::move(options)) {
  std::vector<double*> parameter_blocks;
  problem.GetParameterBlocks(&parameter_blocks);
  for (double* values : parameter_blocks) {
    const int size = problem.ParameterBlockSize(values);
    // Ceres 2.1 wraps a LocalParameterization, which Ceres 2.2 removed, in a Manifold.
    const ceres::Manifold* const kind = problem.GetManifold(values);
    const auto manifold = kind != nullptr ? std::make_shared<ManifoldOf>(*kind) : nullptr;
    const bool fixed = problem.IsParameterBlockConstant(values) || (manifold && manifold->tangent_size() == 0);
    const int block = problem_.AddParameterBlock(values, size, fixed ? nullptr : manifold);
    if (fixed) problem_.SetConstant(block);
    for (int entry = 0; entry < size; ++entry) {
      // Ceres represents an absent bound by the largest double.
      constexpr double kNone = std::numeric_limits<double>::max(), kInfinity = std::numeric_limits<double>::infinity();
      const double lower = problem.GetParameterLowerBound(values, entry);
      const double upper = problem.GetParameterUpperBound(values, entry);
      if (lower <= -kNone && upper >= kNone) continue;
      if (fixed) {
        if (!bounds_internal::Inside(values[entry], lower, upper) && infeasible_.empty()) {
          infeasible_ =
              fmt::format("parameter block {} is constant, and its entry {} is {}, outside of [{}, {}]; move it inside",
                          block, entry, values[entry], lower, upper);
        }
        continue;
      }
      if (!(lower <= upper)) {
        if (infeasible_.empty()) {
          infeasible_ = fmt::format("parameter block {}, entry {}: the lower bound {} is above the upper bound {}",
                                    block, entry, lower, upper);
        }
        continue;
      }
      problem_.SetBounds(block, entry, lower <= -kNone ? -kInfinity : lower, upper >= kNone ? kInfinity : upper);
    }
  }
  std::vector<ceres::ResidualBlockId> residual_blocks;
  problem.GetResidualBlocks(&residual_blocks);
  problem_.ReserveResidualBlocks(residual_blocks.size());
  std::unordered_map<const ceres::LossFunction*, std::shared_ptr<const Loss>> losses;
  std::vector<double*> arguments;
  std::vector<int> blocks;
  for (const ceres::ResidualBlockId id : residual_blocks) {
    const ceres::LossFunction* loss = problem.GetLossFunctionForResidualBlock(id);
    const Cost& cost = costs_.emplace_back(*problem.GetCostFunctionForResidualBlock(id));
    std::shared_ptr<const Loss> our_loss;
    if (loss) {
      auto& known = losses[loss];
      if (!known) known = std::make_shared<LossOf>(*loss);
      our_loss = known;
    }
    problem.GetParameterBlocksForResidualBlock(id, &arguments);
    blocks.clear();
    for (const double* values : arguments) blocks.push_back(problem_.FindParameterBlock(values));
    // costs_ owns the cost function, so this pointer does not count references.
    problem_.AddResidualBlock({std::shared_ptr<const CostFunction>(), &cost}, std::move(our_loss), blocks);
  }
}

void CeresProblem::SetEvaluationCallback(ceres::EvaluationCallback* callback) {
  if (callback == nullptr) return problem_.set_evaluation_callback({});
  problem_.set_evaluation_callback(
      [this, callback, last = std::vector<double>()](CpuBackend<double>::ConstVectorView x, bool jacobians) mutable {
        const bool is_new = !std::equal(x.begin(), x.end(), last.begin(), last.end());
        if (is_new) last.assign(x.begin(), x.end());
        Scatter(x);
        callback->PrepareForEvaluation(jacobians, is_new);
      });
}

}  // namespace vesta::ceres_bridge
