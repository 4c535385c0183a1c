// SPDX-License-Identifier: Apache-2.0
// Messages of a BlockProblem for failed solves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "solver/block_problem.h"
#include "solver/internal/evaluation_faults.h"

namespace vesta {

std::string BlockProblem::NameTangent(Index k) {
  const std::vector<FreeBlock>& free = Structure().free_blocks();
  const auto next =
      std::upper_bound(free.begin(), free.end(), k, [](Index at, const FreeBlock& each) { return at < each.offset; });
  if (next == free.begin() || k >= Structure().num_tangent()) return "";
  const FreeBlock& block = *std::prev(next);
  const char* const of = manifolds_[static_cast<std::size_t>(block.parameter)] ? "tangent entry" : "entry";
  return fmt::format("{} {} of parameter block {}", of, k - block.offset, block.parameter);
}

std::string BlockProblem::NameResidual(int, Index row) {
  const std::vector<BlockRow>& rows = Structure().rows();
  const auto next = std::upper_bound(rows.begin(), rows.end(), row,
                                     [](Index at, const BlockRow& each) { return at < each.residual_offset; });
  const BlockRow& block = *std::prev(next);
  return fmt::format("residual {} of residual block {}", row - block.residual_offset, block.residual_block);
}

std::string BlockProblem::DescribeTerm(ConstVectorView x, std::size_t term, bool jacobians, Scratch& scratch) const {
  const ResidualBlock block = residuals_[term];
  const auto values_of = [&](int p) {
    const ParameterBlock& parameter = parameters_[static_cast<std::size_t>(p)];
    return std::span(x.data() + parameter.ambient_offset, static_cast<std::size_t>(parameter.ambient_size));
  };
  const auto at = [&] {
    std::string text = ", at parameter block";
    for (std::size_t i = 0; i < block.parameters.size(); ++i) {
      text += fmt::format("{} {} = {}", i == 0 ? "" : ",", block.parameters[i],
                          DescribeNumbers(values_of(block.parameters[i])));
    }
    return text;
  };
  std::vector<double>& residuals = scratch.residuals;
  residuals.resize(static_cast<std::size_t>(block.num_residuals));
  if (!EvaluateTerm(x, term, residuals.data(), scratch)) {
    return fmt::format("residual block {} returns false{}", term, at());
  }
  double square = 0;
  for (int i = 0; i < block.num_residuals; ++i) {
    const double value = residuals[static_cast<std::size_t>(i)];
    if (!std::isfinite(value)) {
      return fmt::format("residual {} of residual block {} {}{}", i, term, DescribeValue(value), at());
    }
    square += value * value;
  }
  if (const Loss* loss = terms_[term].loss.get()) {
    const double rho = loss->Evaluate(square).rho;
    if (!std::isfinite(rho)) return DescribeLossValue(static_cast<Index>(term), square, rho) + at();
  }
  for (std::size_t a = 0; jacobians && a < block.parameters.size(); ++a) {
    const int p = block.parameters[a], size = parameters_[static_cast<std::size_t>(p)].ambient_size;
    if (scratch.jacobians[a] == nullptr) continue;
    for (int k = 0; k < block.num_residuals * size; ++k) {
      const double value = scratch.jacobians[a][k];
      if (std::isfinite(value)) continue;
      return fmt::format("the derivative of residual {} of residual block {} by entry {} of parameter block {} {}{}",
                         k / size, term, k % size, p, DescribeValue(value), at());
    }
    if (const Manifold* manifold = manifolds_[static_cast<std::size_t>(p)].get()) {
      std::vector<double>& plus = scratch.plus_jacobian;
      plus.assign(static_cast<std::size_t>(Index{size} * manifold->tangent_size()), Unwritten<double>());
      manifold->PlusJacobian(scratch.arguments[a], plus.data());
      const auto bad = std::find_if(plus.begin(), plus.end(), [](double value) { return !std::isfinite(value); });
      if (bad != plus.end()) {
        return fmt::format("entry {} of PlusJacobian of parameter block {} {}, at {}", bad - plus.begin(), p,
                           DescribeValue(*bad), DescribeNumbers(values_of(p)));
      }
    }
  }
  return "";
}

std::string BlockProblem::DescribeNonFinite(ConstVectorView x, bool jacobians) {
  if (options_.evaluation_callback) options_.evaluation_callback(x, true);
  Scratch scratch;
  for (std::size_t term = 0; term < residuals_.size(); ++term) {
    if (residuals_[term].num_residuals == 0) continue;  // removed
    if (std::string what = DescribeTerm(x, term, jacobians, scratch); !what.empty()) return what;
  }
  return "";
}

std::string BlockProblem::DescribeDegenerate(ConstVectorView x) {
  std::vector<double> jacobian;
  for (const FreeBlock& free : Structure().free_blocks()) {
    const auto p = static_cast<std::size_t>(free.parameter);
    const Manifold* manifold = manifolds_[p].get();
    if (!manifold) continue;
    const Index rows = parameters_[p].ambient_size, cols = free.size;
    jacobian.assign(static_cast<std::size_t>(rows * cols), Unwritten<double>());
    manifold->PlusJacobian(x.data() + parameters_[p].ambient_offset, jacobian.data());
    for (Index c = 0; c < cols; ++c) {
      double square = 0;
      for (Index i = 0; i < rows; ++i) square += std::pow(jacobian[static_cast<std::size_t>(i * cols + c)], 2);
      if (square > 0 && std::isfinite(square)) continue;
      return fmt::format(
          "a step cannot move parameter block {} from where it starts: its manifold has no derivative there; start it "
          "at a valid point (a quaternion at length 1, not at zeros)",
          free.parameter);
    }
  }
  return "";
}

}  // namespace vesta
