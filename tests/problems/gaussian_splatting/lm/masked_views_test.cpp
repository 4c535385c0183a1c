// SPDX-License-Identifier: Apache-2.0
// Masked views in the LM problem and the loss.
#include <gtest/gtest.h>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "solver/internal/derivative_check.inl"
#include "tests/problems/gaussian_splatting/host_vectors.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/linearize_at.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

using B = CpuBackend<double>;
using test::RandomVector;
using test::RingProblem;

constexpr Index kCount = 30;

// Masks exclude half of the first two views (with an oblique border), no pixel of the third, and all of the last.
struct MaskedRing {
  RingProblem<double> ring{4, kCount, 2, 30};
  std::vector<std::vector<std::uint8_t>> masks;

  MaskedRing() {
    masks.reserve(ring.views.size());
    for (std::size_t v = 0; v < ring.views.size(); ++v) {
      auto& target = ring.views[v];
      std::vector<std::uint8_t>& mask = masks.emplace_back();
      if (v == 2) continue;
      for (int y = 0; y < target.camera.height; ++y) {
        for (int x = 0; x < target.camera.width; ++x) mask.push_back(v < 2 && x + y < 30 ? 255 : 0);
      }
      target.mask = {mask.data(), static_cast<Index>(mask.size())};
    }
  }
};

TEST(MaskedViews, GradientIsTheDerivativeOfTheCost) {
  B backend;
  const MaskedRing masked;
  SplatProblem<B> problem = masked.ring.Make();
  for (std::uint64_t seed = 31; seed < 34; ++seed) {
    const HostBuffer<double> v = RandomVector<double>(problem.num_parameters(), seed);
    EXPECT_LE((GradientError<B>(backend, problem, masked.ring.x, v, 1e-7)), 1e-5);
  }
}

TEST(MaskedViews, CostLessAndNothingWhereNothingCounts) {
  MaskedRing masked;
  const RingProblem<double> unmasked(4, kCount, 2, 30);
  SplatProblem<B> problem = masked.ring.Make(), whole = unmasked.Make();
  const auto cost = [&](SplatProblem<B>& of, Index view) { return of.Cost(masked.ring.x, std::vector<Index>{view}); };
  EXPECT_LT(cost(problem, 0), 0.8 * cost(whole, 0));
  EXPECT_EQ(cost(problem, 2), cost(whole, 2));
  // The value of |e| with its floor at zero error.
  const PhotometricWeights& weights = masked.ring.options.weights;
  EXPECT_NEAR(cost(problem, 3), 40 * 30 * 3 * weights.l1 * weights.l1_floor / 2, 1e-9);
}

// For all ways of caching a view.
TEST(MaskedViews, HIsTheProductOfItsPartsAndSymmetric) {
  B backend;
  for (const JacobianKind kind : {JacobianKind::kCachedViews, JacobianKind::kCache32, JacobianKind::kOnTheFly}) {
    SCOPED_TRACE(static_cast<int>(kind));
    MaskedRing masked;
    masked.ring.options.jacobian = kind;
    SplatProblem<B> problem = masked.ring.Make();
    const auto linearization = LinearizeAt(problem, masked.ring.x);
    const HostBuffer<double> v = RandomVector<double>(problem.num_parameters(), 21),
                             w = RandomVector<double>(v.size(), 22);
    const Index rows = linearization->num_residuals();
    const HostBuffer<double> Hv = test::ApplyH(*linearization, v), Hw = test::ApplyH(*linearization, w);
    ASSERT_GT(test::Norm(Hv), 0);
    EXPECT_NEAR(backend.Dot(w, Hv), backend.Dot(v, Hw), 1e-10 * test::Norm(Hv) * test::Norm(w));
    EXPECT_LE(test::Distance(test::ApplyParts(*linearization, v), Hv), 1e-10 * test::Norm(Hv));
    const HostBuffer<double> u = RandomVector<double>(rows, 23);
    HostBuffer<double> Jv(rows), JTu(v.size());
    linearization->ApplyJ(v, Jv);
    linearization->ApplyJT(u, JTu);
    EXPECT_NEAR(backend.Dot(Jv, u), backend.Dot(v, JTu), 1e-9 * test::Norm(Jv) * 100);
    // The last view's rows, which come last, are zero.
    const Index of_view = rows / 4;
    for (Index i = rows - of_view; i < rows; ++i) {
      ASSERT_EQ(Jv[i], 0);
      ASSERT_EQ(linearization->residuals()[i], 0);
    }
  }
}

TEST(MaskedViews, AMaskOfAllIsNone) {
  MaskedRing masked;
  for (std::size_t v = 0; v < 4; ++v) {
    masked.masks[v].assign(40 * 30, 1);
    masked.ring.views[v].mask = {masked.masks[v].data(), 40 * 30};
  }
  const RingProblem<double> unmasked(4, kCount, 2, 30);
  SplatProblem<B> problem = masked.ring.Make(), whole = unmasked.Make();
  EXPECT_EQ(problem.Cost(masked.ring.x), whole.Cost(masked.ring.x));
}

}  // namespace
}  // namespace vesta::gs
