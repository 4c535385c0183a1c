// SPDX-License-Identifier: Apache-2.0
// Solves of small problems do not allocate memory.
#include <gtest/gtest.h>

#include <array>

#include "solver/small_solver.h"
#include "tests/solver/small_functors.h"
#include "tests/support/counted_memory.h"

namespace vesta {
namespace {

struct RosenbrockAtRunTime : Rosenbrock {
  static constexpr int kResiduals = kResidualsAtRunTime;
  int num_residuals() const { return 2; }
};

TEST(SmallSolverMemory, IsOnTheStack) {
  const test::CountedMemory memory;
  const SmallSolver<Rosenbrock> solver;
  std::array x{-1.2, 1.0};
  EXPECT_TRUE(IsConverged(solver.Solve({}, x).status));
  std::array<double, 8> coefficients{};  // with rotations of J
  SmallSolver<Monomials>().Solve({}, coefficients);
  EXPECT_EQ(memory.peak_bytes(), 0);
}

TEST(SmallSolverMemory, IsReusedWithAWorkspace) {
  const SmallSolver<RosenbrockAtRunTime> solver;
  SmallSolver<RosenbrockAtRunTime>::Workspace workspace;
  std::array x{-1.2, 1.0};
  {
    const test::CountedMemory memory;
    solver.Solve({}, x, workspace);
    EXPECT_GT(memory.peak_bytes(), 0);
  }
  x = {-1.2, 1.0};
  const test::CountedMemory memory;
  EXPECT_TRUE(IsConverged(solver.Solve({}, x, workspace).status));
  EXPECT_EQ(memory.peak_bytes(), 0);
}

}  // namespace
}  // namespace vesta
