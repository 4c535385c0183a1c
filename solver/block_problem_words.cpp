// What a BlockProblem says of itself where a solve fails.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

#include "solver/block_problem.h"

namespace vesta {

std::string BlockProblem::NameTangent(Index k) {
  for (const FreeBlock& free : Structure().free_blocks()) {
    if (k < free.offset || k >= free.offset + free.size) continue;
    const char* const of = manifolds_[static_cast<std::size_t>(free.parameter)] ? "tangent entry" : "entry";
    return fmt::format("{} {} of parameter block {}", of, k - free.offset, free.parameter);
  }
  return Problem::NameTangent(k);
}

std::string BlockProblem::DescribeDegenerate(ConstView x) {
  std::vector<double> jacobian;
  for (const FreeBlock& free : Structure().free_blocks()) {
    const auto p = static_cast<std::size_t>(free.parameter);
    const Manifold* manifold = manifolds_[p].get();
    if (!manifold) continue;
    const int rows = parameters_[p].ambient_size, cols = free.size;
    jacobian.assign(static_cast<std::size_t>(rows * cols), std::numeric_limits<double>::quiet_NaN());
    manifold->PlusJacobian(x.data() + parameters_[p].ambient_offset, jacobian.data());
    for (int c = 0; c < cols; ++c) {
      double square = 0;
      for (int i = 0; i < rows; ++i) square += std::pow(jacobian[static_cast<std::size_t>(i * cols + c)], 2);
      if (square > 0 && std::isfinite(square)) continue;
      return fmt::format(
          "a step cannot move parameter block {} from where it starts: its manifold has no derivative there; start it "
          "at "
          "a valid point (a quaternion at length 1, not at zeros)",
          free.parameter);
    }
  }
  return "";
}

}  // namespace vesta
