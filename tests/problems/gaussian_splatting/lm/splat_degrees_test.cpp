// SPDX-License-Identifier: Apache-2.0
// Gaussians with different SH degrees.
#include <gtest/gtest.h>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs::test {
namespace {

constexpr int kViews = 3;
constexpr Index kCount = 30;

// Mixed degrees give the results of zeros in the missing bands.
template <class S>
void ExpectThatDegreesMayDiffer() {
  const SplatModel mixed = WithDegrees(RandomModel(kCount, 3, 66), MixedDegrees(static_cast<std::size_t>(kCount))),
                   zeros = AtOneDegree(mixed);
  Scene scene = RingOfCameras(kViews, 40, 30, false);
  RenderTruth(RandomModel(kCount, 3, 67), 0, &scene);
  RingProblem<S> ring(scene, mixed), ring_of_zeros(scene, zeros);
  SplatProblem<CpuBackend<S>> problem = ring.Make(), problem_of_zeros = ring_of_zeros.Make();
  EXPECT_EQ(problem.num_parameters(), mixed.Size());
  EXPECT_EQ(problem.Cost(ring.x), problem_of_zeros.Cost(ring_of_zeros.x));
  const auto linear = LinearizeAt(problem, ring.x), linear_of_zeros = LinearizeAt(problem_of_zeros, ring_of_zeros.x);
  HostBuffer<S> found(mixed.Size()), all(zeros.Size()), diagonal(mixed.Size()), metric(mixed.Size()),
      all_metric(zeros.Size());
  const auto expect_same = [&](const HostBuffer<S>& some, const HostBuffer<S>& every) {
    for (int a = 0; a < mixed.num_attributes(); ++a) {
      for (Index i = 0; i < mixed.Rows(a); ++i) ASSERT_EQ(some[mixed.Offset(a) + i], every[zeros.Offset(a) + i]) << a;
    }
  };
  linear->Gradient(found), linear_of_zeros->Gradient(all);
  expect_same(found, all);
  linear->DiagJTJ(diagonal), linear_of_zeros->DiagJTJ(all);
  expect_same(diagonal, all);
  EXPECT_TRUE(problem.DampingMetric(ring.x, diagonal, metric));
  EXPECT_TRUE(problem_of_zeros.DampingMetric(ring_of_zeros.x, all, all_metric));
  expect_same(metric, all_metric);
  // The blocks of the preconditioner cover each parameter once.
  BlockDiagonal<CpuBackend<S>> blocks(mixed.Size(), linear->block_groups());
  linear->BlockGram(blocks);
}

TEST(SplatDegrees, MayDifferInDouble) { ExpectThatDegreesMayDiffer<double>(); }
TEST(SplatDegrees, MayDifferInFloat) { ExpectThatDegreesMayDiffer<float>(); }

}  // namespace
}  // namespace vesta::gs::test
