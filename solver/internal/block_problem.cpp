// SPDX-License-Identifier: Apache-2.0
#include "solver/block_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "solver/bounds.h"
#include "solver/internal/block_linearization.h"
#include "solver/internal/blocks/block_structure.h"
#include "solver/internal/evaluation_faults.h"

namespace vesta {

namespace {
constexpr Index kGrain = 64;
}

void BlockProblem::Changed() {
  structure_.reset();
  normal_matrix_.reset();
  cholesky_.reset();
  couplings_.reset();
  reduced_matrix_.reset();
  counts_.reset();
}

const BlockStructure& BlockProblem::Structure() const {
  if (!structure_) structure_.emplace(parameters_, residuals_, options_.eliminate && !options_.dynamic_sparsity);
  return *structure_;
}

Index BlockProblem::tangent_offset(int block) {
  Parameter(block);  // throws if there is no such block
  const FreeBlock* const free = Structure().Find(block);
  return free ? free->offset : -1;
}

int BlockProblem::tangent_size(int block) {
  Parameter(block);
  const FreeBlock* const free = Structure().Find(block);
  return free ? free->size : 0;
}

inline void BlockProblem::Prepare(ConstVectorView x, std::size_t term, double* residuals, Scratch& scratch) const {
  const ResidualBlock block = residuals_[term];
  const std::size_t count = block.parameters.size();
  scratch.arguments.resize(count);
  const double** arguments = scratch.arguments.data();
  for (std::size_t i = 0; i < count; ++i) {
    arguments[i] = x.data() + parameters_[static_cast<std::size_t>(block.parameters[i])].ambient_offset;
  }
  for (int i = 0; i < block.num_residuals; ++i) residuals[i] = Unwritten<double>();
}

bool BlockProblem::EvaluateTerm(ConstVectorView x, std::size_t term, double* residuals, Scratch& scratch) const {
  Prepare(x, term, residuals, scratch);
  const ResidualBlock block = residuals_[term];
  const auto entries = [&](int p) {
    const ParameterBlock& parameter = parameters_[static_cast<std::size_t>(p)];
    return parameter.tangent_size > 0 ? block.num_residuals * parameter.ambient_size : 0;
  };
  int all = 0;
  for (const int p : block.parameters) all += entries(p);
  scratch.ambient.assign(static_cast<std::size_t>(all), Unwritten<double>());
  scratch.jacobians.clear();
  double* next = scratch.ambient.data();
  for (const int p : block.parameters) {
    scratch.jacobians.push_back(entries(p) > 0 ? next : nullptr);
    next += entries(p);
  }
  return terms_[term].cost->Evaluate(scratch.arguments.data(), residuals, scratch.jacobians.data());
}

double BlockProblem::TermCost(ConstVectorView x, std::size_t term, Scratch& scratch) const {
  const int num_residuals = residuals_[term].num_residuals;
  if (num_residuals == 0) return 0;  // removed
  scratch.residuals.resize(static_cast<std::size_t>(num_residuals));
  Prepare(x, term, scratch.residuals.data(), scratch);
  if (!terms_[term].cost->Evaluate(scratch.arguments.data(), scratch.residuals.data(), nullptr)) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    scratch.residuals.assign(scratch.residuals.size(), kNaN);
    return kNaN;
  }
  double s = 0;
  for (const double r : scratch.residuals) s += r * r;
  return 0.5 * (terms_[term].loss ? terms_[term].loss->Evaluate(s).rho : s);
}

template <class TermOf>
double BlockProblem::SumCosts(ConstVectorView x, Index count, const TermOf& term_of) const {
  CheckSize(x);
  if (options_.evaluation_callback) options_.evaluation_callback(x, false);
  return ParallelSum<double>(count, kGrain, [&](Index begin, Index end) {
    Scratch scratch;
    double sum = 0;
    for (Index i = begin; i < end; ++i) sum += TermCost(x, static_cast<std::size_t>(term_of(i)), scratch);
    return sum;
  });
}

double BlockProblem::Cost(ConstVectorView x) {
  return SumCosts(x, static_cast<Index>(residuals_.size()), [](Index i) { return i; });
}

double BlockProblem::FixedCost(ConstVectorView x) {
  const std::vector<Index>& fixed = Structure().fixed_residual_blocks();
  if (fixed.empty()) return 0;
  return SumCosts(x, static_cast<Index>(fixed.size()), [&](Index i) { return fixed[static_cast<std::size_t>(i)]; });
}

double BlockProblem::VariableCost(ConstVectorView x) {
  const std::vector<BlockRow>& rows = Structure().rows();
  if (rows.size() == residuals_.size()) return Cost(x);
  return SumCosts(x, num_units(), [&](Index i) { return rows[static_cast<std::size_t>(i)].residual_block; });
}

double BlockProblem::Cost(ConstVectorView x, std::span<const Index> units) {
  CheckUnits(units);
  const std::vector<BlockRow>& rows = Structure().rows();
  return SumCosts(x, static_cast<Index>(units.size()), [&](Index i) {
    return rows[static_cast<std::size_t>(units[static_cast<std::size_t>(i)])].residual_block;
  });
}

template <class T, class Of>
T BlockProblem::SumVariable(const Of& of) const {
  const std::vector<FreeBlock>& free = Structure().free_blocks();
  return ParallelSum<T>(static_cast<Index>(free.size()), 4 * kGrain, [&](Index begin, Index end) {
    T sum{};
    for (Index k = begin; k < end; ++k) {
      const auto p = static_cast<std::size_t>(free[static_cast<std::size_t>(k)].parameter);
      const Index first = parameters_[p].ambient_offset;
      for (Index i = first; i < first + parameters_[p].ambient_size; ++i) sum += of(i);
    }
    return sum;
  });
}

double BlockProblem::VariableNorm(ConstVectorView x) {
  const bool all = Structure().free_blocks().size() == parameters_.size();
  return std::sqrt(all ? B().Dot(x, x) : SumVariable<double>([&](Index i) { return x[i] * x[i]; }));
}

double BlockProblem::VariableMaxChange(ConstVectorView x, VectorView y) {
  return SumVariable<Largest>([&](Index i) { return Largest{std::abs(y[i] - x[i])}; }).value;
}

std::unique_ptr<Linearization<BlockProblem::B>> BlockProblem::Linearize(ConstVectorView x) {
  CheckSize(x);
  if (options_.evaluation_callback) options_.evaluation_callback(x, true);
  return std::make_unique<BlockLinearization>(*this, x);
}

void BlockProblem::Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) {
  backend.Copy(x, out);
  const std::vector<FreeBlock>& free = Structure().free_blocks();
  ParallelFor(static_cast<Index>(free.size()), 4 * kGrain, [&](Index k) {
    const FreeBlock& block = free[static_cast<std::size_t>(k)];
    const auto p = static_cast<std::size_t>(block.parameter);
    double* to = out.data() + parameters_[p].ambient_offset;
    const double* step = delta.data() + block.offset;
    if (manifolds_[p]) {
      manifolds_[p]->Plus(to, step, to);
    } else {
      for (int c = 0; c < block.size; ++c) to[c] += step[c];
    }
    if (!has_bounds()) return;
    for (int c = 0; c < parameters_[p].ambient_size; ++c) {
      const auto i = static_cast<std::size_t>(parameters_[p].ambient_offset + c);
      to[c] = std::min(std::max(to[c], lower_[i]), upper_[i]);
    }
  });
}

std::string BlockProblem::DescribeInfeasible(ConstVectorView x) {
  if (!has_bounds()) return "";
  for (const FreeBlock& block : Structure().free_blocks()) {
    const auto p = static_cast<std::size_t>(block.parameter);
    for (int c = 0; c < parameters_[p].ambient_size; ++c) {
      const Index i = parameters_[p].ambient_offset + c;
      const auto k = static_cast<std::size_t>(i);
      if (bounds_internal::Inside(x[i], lower_[k], upper_[k])) continue;
      return fmt::format("block {}, entry {}: {}", p, c, bounds_internal::Outside(x[i], lower_[k], upper_[k]));
    }
  }
  return "";
}

template <class Visit>
void BlockProblem::VisitEuclidean(const Visit& visit) const {
  if (!has_bounds()) return;
  for (const FreeBlock& block : Structure().free_blocks()) {
    const auto p = static_cast<std::size_t>(block.parameter);
    if (manifolds_[p]) continue;
    for (int c = 0; c < block.size; ++c) visit(parameters_[p].ambient_offset + c, block.offset + c);
  }
}

void BlockProblem::MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) {
  VisitEuclidean([&](Index i, Index k) {
    const auto b = static_cast<std::size_t>(i);
    if (bounds_internal::PushedOut(x[i], negative_gradient[k], lower_[b], upper_[b])) mask[k] = 0;
  });
}

void BlockProblem::ClipStep(ConstVectorView x, VectorView step) {
  VisitEuclidean([&](Index i, Index k) {
    const auto b = static_cast<std::size_t>(i);
    step[k] = bounds_internal::ClippedStep(x[i], step[k], lower_[b], upper_[b]);
  });
}

}  // namespace vesta
