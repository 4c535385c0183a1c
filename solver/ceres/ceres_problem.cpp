#include "solver/ceres/ceres_problem.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "kernels/core/check.h"

namespace vesta::ceres_bridge {

namespace {

class Cost final : public CostFunction {
 public:
  explicit Cost(const ceres::CostFunction& cost)
      : CostFunction(cost.num_residuals(), {cost.parameter_block_sizes().begin(), cost.parameter_block_sizes().end()}),
        cost_(cost) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    return cost_.Evaluate(parameters, residuals, jacobians);
  }

 private:
  const ceres::CostFunction& cost_;
};

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

// Sizes in a common spelling for Ceres's two kinds.
int AmbientSize(const ceres::Manifold& manifold) { return manifold.AmbientSize(); }
int TangentSize(const ceres::Manifold& manifold) { return manifold.TangentSize(); }
bool PlusJacobianOf(const ceres::Manifold& manifold, const double* x, double* jacobian) {
  return manifold.PlusJacobian(x, jacobian);
}
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
int AmbientSize(const ceres::LocalParameterization& kind) { return kind.GlobalSize(); }
int TangentSize(const ceres::LocalParameterization& kind) { return kind.LocalSize(); }
bool PlusJacobianOf(const ceres::LocalParameterization& kind, const double* x, double* jacobian) {
  return kind.ComputeJacobian(x, jacobian);
}

template <class Kind>
class ManifoldOf final : public Manifold {
 public:
  explicit ManifoldOf(const Kind& kind) : kind_(kind) {}
  int ambient_size() const override { return AmbientSize(kind_); }
  int tangent_size() const override { return TangentSize(kind_); }
  void Plus(const double* x, const double* delta, double* out) const override {
    // Ceres does not promise to work in place.
    std::vector<double> from(x, x + ambient_size());
    if (!kind_.Plus(from.data(), delta, out))
      std::fill_n(out, ambient_size(), std::numeric_limits<double>::quiet_NaN());
  }
  void PlusJacobian(const double* x, double* jacobian) const override {
    if (!PlusJacobianOf(kind_, x, jacobian)) {
      std::fill_n(jacobian, ambient_size() * tangent_size(), std::numeric_limits<double>::quiet_NaN());
    }
  }

 private:
  const Kind& kind_;
};

std::shared_ptr<const Manifold> ManifoldFor(const ceres::Problem& problem, const double* values) {
  if (problem.HasManifold(values)) {
    return std::make_shared<ManifoldOf<ceres::Manifold>>(*problem.GetManifold(values));
  }
  if (problem.HasParameterization(values)) {
    return std::make_shared<ManifoldOf<ceres::LocalParameterization>>(*problem.GetParameterization(values));
  }
  return nullptr;
}
#pragma GCC diagnostic pop

}  // namespace

CeresProblem::CeresProblem(ceres::Problem& problem, BlockProblem::Options options) : problem_(std::move(options)) {
  problem.GetParameterBlocks(&values_);
  for (const double* values : values_) {
    const int size = problem.ParameterBlockSize(values);
    const auto manifold = ManifoldFor(problem, values);
    const bool fixed = problem.IsParameterBlockConstant(values) || (manifold && manifold->tangent_size() == 0);
    const int block = problem_.AddParameterBlock(size, fixed ? nullptr : manifold);
    block_of_[values] = block;
    if (fixed) problem_.SetConstant(block);
    for (int entry = 0; entry < size; ++entry) {
      // Ceres says "none" by the largest double.
      constexpr double kNone = std::numeric_limits<double>::max(), kInfinity = std::numeric_limits<double>::infinity();
      const double lower = problem.GetParameterLowerBound(values, entry);
      const double upper = problem.GetParameterUpperBound(values, entry);
      if (lower <= -kNone && upper >= kNone) continue;
      problem_.SetBounds(block, entry, lower <= -kNone ? -kInfinity : lower, upper >= kNone ? kInfinity : upper);
    }
  }
  std::vector<ceres::ResidualBlockId> residual_blocks;
  problem.GetResidualBlocks(&residual_blocks);
  std::unordered_map<const ceres::CostFunction*, std::shared_ptr<const CostFunction>> costs;
  std::unordered_map<const ceres::LossFunction*, std::shared_ptr<const Loss>> losses;
  std::vector<double*> arguments;
  for (const ceres::ResidualBlockId id : residual_blocks) {
    const ceres::CostFunction* cost = problem.GetCostFunctionForResidualBlock(id);
    const ceres::LossFunction* loss = problem.GetLossFunctionForResidualBlock(id);
    auto& our_cost = costs[cost];
    if (!our_cost) our_cost = std::make_shared<Cost>(*cost);
    std::shared_ptr<const Loss> our_loss;
    if (loss) {
      auto& known = losses[loss];
      if (!known) known = std::make_shared<LossOf>(*loss);
      our_loss = known;
    }
    problem.GetParameterBlocksForResidualBlock(id, &arguments);
    std::vector<int> blocks;
    blocks.reserve(arguments.size());
    for (const double* values : arguments) blocks.push_back(block_of_.at(values));
    problem_.AddResidualBlock(our_cost, our_loss, std::move(blocks));
  }
}

CpuBackend<double>::Vector CeresProblem::Gather() const {
  CpuBackend<double>::Vector x(problem_.num_parameters());
  for (std::size_t b = 0; b < values_.size(); ++b) {
    const int block = static_cast<int>(b);
    std::copy_n(values_[b], problem_.parameter_block_size(block), x.data() + problem_.offset(block));
  }
  return x;
}

void CeresProblem::Scatter(CpuBackend<double>::ConstView x) const {
  for (std::size_t b = 0; b < values_.size(); ++b) {
    const int block = static_cast<int>(b);
    std::copy_n(x.data() + problem_.offset(block), problem_.parameter_block_size(block), values_[b]);
  }
}

int CeresProblem::block(const double* values) const {
  const auto found = block_of_.find(values);
  VESTA_CHECK(found != block_of_.end(), "the address is no parameter block of the problem");
  return found->second;
}

LmSummary Solve(const LmOptions& options, ceres::Problem& problem, const LmCallback& callback) {
  CeresProblem bridge(problem);
  CpuBackend<double> backend;
  auto x = bridge.Gather();
  LmSummary summary = SolveLm<CpuBackend<double>>(options, backend, bridge.problem(), x.view(), callback);
  bridge.Scatter(x);
  return summary;
}

LmOptions FromCeres(const ceres::Solver::Options& from) {
  LmOptions options;
  options.max_iterations = from.max_num_iterations;
  options.max_seconds = from.max_solver_time_in_seconds;
  options.function_tolerance = from.function_tolerance;
  options.gradient_tolerance = from.gradient_tolerance;
  options.parameter_tolerance = from.parameter_tolerance;
  options.step_control.initial_lambda = 1 / from.initial_trust_region_radius;
  options.step_control.min_lambda = 1 / from.max_trust_region_radius;
  options.step_control.max_lambda = 1 / from.min_trust_region_radius;
  options.step_control.min_relative_decrease = from.min_relative_decrease;
  options.column_scaling = from.jacobi_scaling ? ColumnScaling::kOnePlusInverse : ColumnScaling::kNone;
  NormalSystemOptions& system = options.normal_system;
  system.metric.min_diagonal = from.min_lm_diagonal;
  system.metric.max_diagonal = from.max_lm_diagonal;
  system.pcg.max_iterations = from.max_linear_solver_iterations;
  system.pcg.min_iterations = from.min_linear_solver_iterations;
  system.pcg.model_tolerance = from.eta;
  switch (from.linear_solver_type) {
    case ceres::DENSE_QR:
    case ceres::DENSE_NORMAL_CHOLESKY:
      system.linear_solver = LinearSolverKind::kDenseQr;
      break;
    case ceres::CGNR:
      system.linear_solver = LinearSolverKind::kPcg;
      system.preconditioner = from.preconditioner_type == ceres::IDENTITY ? PreconditionerKind::kIdentity
                                                                          : PreconditionerKind::kBlockJacobi;
      break;
    case ceres::SPARSE_NORMAL_CHOLESKY:
      system.linear_solver = LinearSolverKind::kPcg;
      system.preconditioner = PreconditionerKind::kSparseCholesky;
      // To rounding, as a direct solver; the second test is for systems whose rounding is above the first.
      system.pcg.relative_tolerance = 1e-10;
      system.pcg.model_tolerance = 1e-4;
      break;
    default:
      system.linear_solver = LinearSolverKind::kAuto;
  }
  return options;
}

}  // namespace vesta::ceres_bridge
