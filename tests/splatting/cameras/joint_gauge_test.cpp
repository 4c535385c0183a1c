// SPDX-License-Identifier: Apache-2.0
// Gauge freedoms of Gaussians and cameras do not change the images; only the prior fixes them.
#include <gtest/gtest.h>

#include "kernels/math/quaternion.h"
#include "kernels/math/spherical_harmonics.h"
#include "tests/splatting/cameras/joint_setup.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs {
namespace {

// Constant colours, because rotations change others; a black background, which no gain changes.
struct GaugeSetup : test::JointSetup<double> {
  GaugeSetup() : JointSetup({true, true}, 3, 20, 0, 21) { options.splats.background = {0, 0, 0}; }
};

// A similarity of the world (rotation `turn`, shift, scale exp(growth)) with all cameras.
HostBuffer<double> SimilarityStep(const GaugeSetup& setup, const JointLayout& layout, const std::array<double, 3>& turn,
                                  const std::array<double, 3>& shift, double growth) {
  HostBuffer<double> v(layout.num_tangent());
  const Index n = setup.model.count;
  const auto cross = [](const auto& a, const double b[3], int i) {
    const auto j = static_cast<std::size_t>((i + 1) % 3), k = static_cast<std::size_t>((i + 2) % 3);
    return a[j] * b[k] - a[k] * b[j];
  };
  for (Index i = 0; i < n; ++i) {
    double mean[3], q[4], dq[4];
    for (int k = 0; k < 3; ++k) mean[k] = setup.x[(splat::kMean + k) * n + i];
    for (int k = 0; k < 4; ++k) q[k] = setup.x[(splat::kQuaternion + k) * n + i];
    const double half[4] = {0, turn[0] / 2, turn[1] / 2, turn[2] / 2};
    QuaternionProduct(half, q, dq);
    for (int k = 0; k < 3; ++k) {
      v[(splat::kMean + k) * n + i] = cross(turn, mean, k) + shift[static_cast<std::size_t>(k)] + growth * mean[k];
      v[(splat::kLogScale + k) * n + i] = growth;
    }
    for (int k = 0; k < 4; ++k) v[(splat::kQuaternion + k) * n + i] = dq[k];
  }
  for (Index view = 0; view < layout.views; ++view) {
    const splat::PosedCamera camera = Moved(setup.ring.views[static_cast<std::size_t>(view)].camera,
                                            layout.UnknownsOf(layout.RestOf(setup.x.view()), view).motion);
    const HostSpan<double> own = layout.StepOf(layout.RestOf(v.view()), view);
    std::array<double, 3> omega{};
    for (int i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) omega[static_cast<std::size_t>(i)] -= camera.R[3 * i + int(k)] * turn[k];
    }
    for (int i = 0; i < 3; ++i) {
      own[i] = omega[static_cast<std::size_t>(i)];
      own[3 + i] = growth * camera.T[i] - cross(omega, camera.T, i);
      for (std::size_t k = 0; k < 3; ++k) own[3 + i] -= camera.R[3 * i + int(k)] * shift[k];
    }
  }
  return v;
}

// Brightens all Gaussians in one channel and lowers that gain of all views.
HostBuffer<double> BrighterStep(const GaugeSetup& setup, const JointLayout& layout, int channel) {
  HostBuffer<double> v(layout.num_tangent());
  const Index n = setup.model.count;
  for (Index i = 0; i < n; ++i) {
    const Index at = (splat::kSh + channel) * n + i;
    v[at] = (0.5 + sh::k0 * setup.x[at]) / sh::k0;
  }
  for (Index view = 0; view < layout.views; ++view) {
    layout.StepOf(layout.RestOf(v.view()), view)[layout.free.Gain(channel)] =
        -layout.UnknownsOf(layout.RestOf(setup.x.view()), view).color.gain[static_cast<std::size_t>(channel)];
  }
  return v;
}

TEST(JointGauge, ImagesStayAndThePriorHolds) {
  const GaugeSetup setup;
  JointProblem<CpuBackend<double>> problem = setup.Make();
  const JointLayout& layout = problem.layout();
  CpuBackend<double> backend;
  const auto linearization = LinearizeAt(problem, setup.x);
  const Index rows = linearization->num_residuals(), priors = layout.views * 12;
  std::vector<HostBuffer<double>> freedoms;
  for (std::size_t k = 0; k < 7; ++k) {
    std::array<double, 7> by{};
    by[k] = 1;
    freedoms.push_back(SimilarityStep(setup, layout, {by[0], by[1], by[2]}, {by[3], by[4], by[5]}, by[6]));
  }
  for (int c = 0; c < 3; ++c) freedoms.push_back(BrighterStep(setup, layout, c));
  for (std::size_t k = 0; k < freedoms.size(); ++k) {
    const HostBuffer<double>& v = freedoms[k];
    HostBuffer<double> u(rows), of_splats(rows), splats(v.size());
    linearization->ApplyJ(v, u);
    std::copy_n(v.begin(), layout.splats, splats.begin());
    linearization->ApplyJ(splats, of_splats);
    const auto images = [&](const HostBuffer<double>& r) { return r.view().subspan(0, rows - priors); };
    const auto prior = u.view().subspan(rows - priors, priors);
    const double size = backend.MaxAbs(images(of_splats));
    ASSERT_GT(size, 0.01) << k;
    EXPECT_LT(backend.MaxAbs(images(u)), 1e-10 * size) << k;
    EXPECT_GT(backend.MaxAbs(prior), 0.1) << k;
    EXPECT_NEAR(linearization->Curvature(v), backend.Dot(prior, prior), 1e-8 * backend.Dot(prior, prior)) << k;
  }
}

// A finite similarity does not change the cost of the photographs, only the prior.
TEST(JointGauge, OnlyThePriorTellsWhereTheWorldIs) {
  GaugeSetup setup;
  const JointLayout layout = setup.Make().layout();
  CpuBackend<double> backend;
  HostBuffer<double> moved(layout.num_parameters());
  const auto cost = [&](double weight, HostSpan<const double> x) {
    setup.options.prior.weight = weight;
    return setup.Make().Cost(x);
  };
  // Shift and growth separately: a linear step is exact for each, with log1p(growth) for the log-scale.
  // exp.
  constexpr double kGrowth = 0.1;
  HostBuffer<double> v = SimilarityStep(setup, layout, {0, 0, 0}, {0.2, -0.1, 0.3}, 0);
  setup.Make().Plus(backend, setup.x, v, moved);
  EXPECT_NEAR(cost(0, moved), cost(0, setup.x), 1e-9 * cost(0, setup.x));
  EXPECT_GT(std::abs(cost(0.5, moved) - cost(0.5, setup.x)), 1e-3 * cost(0, setup.x));
  v = SimilarityStep(setup, layout, {0, 0, 0}, {0, 0, 0}, kGrowth);
  for (int k = 0; k < 3; ++k) {
    for (Index i = 0; i < setup.model.count; ++i) {
      v[(splat::kLogScale + k) * setup.model.count + i] = std::log1p(kGrowth);
    }
  }
  setup.Make().Plus(backend, setup.x, v, moved);
  EXPECT_NEAR(cost(0, moved), cost(0, setup.x), 1e-9 * cost(0, setup.x));
}

}  // namespace
}  // namespace vesta::gs
