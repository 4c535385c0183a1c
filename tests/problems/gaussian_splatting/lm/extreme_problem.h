// SPDX-License-Identifier: Apache-2.0
// Splatting problems with extreme images and cameras, and their checks for every precision and memory space.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <vector>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/internal/derivative_check.inl"
#include "solver/levenberg_marquardt.h"
#include "solver/lm_options.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/adjoint.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs::test {

inline constexpr Index kExtremeCount = 20;  // Gaussians

struct ExtremeProblem {
  const char* name;
  int width, height, views;
  void (*change)(Scene& scene);
  bool fits = false;  // the start renders exactly the truth
};
inline void PrintTo(const ExtremeProblem& c, std::ostream* os) { *os << c.name; }

inline void FillImages(Scene& scene, float value) {
  for (View& view : scene.views) std::fill(view.image.rgb.begin(), view.image.rgb.end(), value);
}
inline void SetLens(Scene& scene, double focal_length, double cx, double cy) {
  for (View& view : scene.views) {
    view.camera.lens.fx = view.camera.lens.fy = focal_length;
    view.camera.lens.cx = cx, view.camera.lens.cy = cy;
  }
}
inline double FocalLength(double degrees, int width) {
  return 0.5 * width / std::tan(0.5 * degrees * std::numbers::pi / 180);
}

inline constexpr ExtremeProblem kExtremeProblems[] = {
    {"Ordinary", 40, 30, 3, [](Scene&) {}},
    {"OnePixel", 1, 1, 3, [](Scene&) {}},
    {"OneRow", 50, 1, 2, [](Scene&) {}},
    {"NoMultipleOfATile", 17, 33, 2, [](Scene&) {}},
    {"AllBlack", 24, 20, 2, [](Scene& scene) { FillImages(scene, 0); }},
    {"AllWhite", 24, 20, 2, [](Scene& scene) { FillImages(scene, 1); }},
    {"EqualToTheRender", 24, 20, 2, [](Scene&) {}, true},
    {"OneView", 24, 20, 1, [](Scene&) {}},
    {"TwoIdenticalViews", 24, 20, 2, [](Scene& scene) { scene.views[1] = scene.views[0]; }},
    {"FieldOf1Degree", 24, 20, 2, [](Scene& scene) { SetLens(scene, FocalLength(1, 24), 12, 10); }},
    {"FieldOf175Degrees", 24, 20, 2, [](Scene& scene) { SetLens(scene, FocalLength(175, 24), 12, 10); }},
    {"PrincipalPointOutside", 24, 20, 2, [](Scene& scene) { SetLens(scene, 36, 28, -4); }},
};

// Images of a random model after the change, and another model as the start.
template <class S>
RingProblem<S> ProblemOf(const ExtremeProblem& c) {
  Scene scene = RingOfCameras(c.views, c.width, c.height, false);
  const SplatModel truth = RandomModel(kExtremeCount, 1, 200);
  RenderTruth(truth, 0, &scene);
  c.change(scene);
  RingProblem<S> ring(scene, c.fits ? truth : RandomModel(kExtremeCount, 1, 201));
  if (!c.fits) return ring;
  splat::ViewWorkspace<S> workspace;
  splat::SplatView<S> view;
  for (std::size_t i = 0; i < ring.views.size(); ++i) {
    view.Build({ring.x.data(), kExtremeCount, 1, 1}, ring.views[i].camera, ring.options.background.data(), workspace);
    view.Render(ring.truth[i].data());
  }
  return ring;
}

template <class Values>
bool IsFinite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](auto value) { return std::isfinite(value); });
}
template <class B>
std::vector<typename B::Scalar> OnHost(B& backend, const typename B::Vector& v) {
  std::vector<typename B::Scalar> values(static_cast<std::size_t>(v.size()));
  backend.ToHost(v, {values.data(), v.size()});
  return values;
}

// Solves from ring.x, in place. The result must be finite and not worse than the start.
template <class B>
LmSummary SolveAndCheck(RingProblem<typename B::Scalar>& ring, const LmStageOptions& lm) {
  B backend;
  const std::vector<TargetView<B>> targets = TargetsIn<B>(ring.views);
  SplatProblem<B> problem(ring.options, targets);
  typename B::Vector x;
  x.CopyFrom(HostSpan<const typename B::Scalar>(ring.x.view()));
  const double before = problem.Cost(x);
  LmSummary summary = SolveLm<B>(LmEngineOptions(lm), backend, problem, x);
  EXPECT_NE(summary.status, LmStatus::kRunning);
  const double after = problem.Cost(x);
  backend.ToHost(x, ring.x.view());
  if (std::isfinite(before)) {
    EXPECT_LE(after, before) << summary.FullReport();
    EXPECT_TRUE(IsFinite(ring.x)) << summary.FullReport();
  }
  return summary;
}

inline LmStageOptions FewIterations() {
  LmStageOptions lm;
  lm.iterations = 4, lm.function_tolerance = 0;
  return lm;
}

// Cost, gradient, curvature and its diagonal must be finite and belong to one quadratic model.
template <class B>
void CheckOperators(const ExtremeProblem& c) {
  using S = typename B::Scalar;
  B backend;
  const RingProblem<S> ring = ProblemOf<S>(c);
  const std::vector<TargetView<B>> targets = TargetsIn<B>(ring.views);
  SplatProblem<B> problem(ring.options, targets);
  const Index n = problem.num_parameters();
  typename B::Vector x, gradient(n), diagonal(n), v(n), w(n), Hv(n), Hw(n);
  x.CopyFrom(HostSpan<const S>(ring.x.view()));
  const double cost = problem.Cost(x);
  EXPECT_TRUE(std::isfinite(cost) && cost >= 0);
  const auto linearization = LinearizeAt(problem, x);
  linearization->Gradient(gradient);
  linearization->DiagJTJ(diagonal);
  const std::vector<S> diagonal_values = OnHost(backend, diagonal);
  EXPECT_TRUE(IsFinite(OnHost(backend, gradient)) && IsFinite(diagonal_values));
  EXPECT_GE(*std::ranges::min_element(diagonal_values), 0);
  FillRandom(backend, 210, v.view());
  FillRandom(backend, 211, w.view());
  linearization->ApplyH(v, Hv);
  linearization->ApplyH(w, Hw);
  EXPECT_GE(backend.Dot(v, Hv), 0);
  const double gap =
      vesta::test::AdjointGap(OnHost(backend, w), OnHost(backend, Hv), OnHost(backend, Hw), OnHost(backend, v));
  EXPECT_LE(gap, (std::is_same_v<S, double> ? 1e-11 : 1e-4));
  if (c.fits) {
    // At the minimum, square roots and weights are singular. The truth was rendered on the host; a device renders
    // slightly different bits.
    EXPECT_LE(backend.MaxAbs(gradient), (std::is_same_v<B, CpuBackend<S>> ? 0 : 1e-3));
  } else if constexpr (std::is_same_v<B, CpuBackend<double>>) {
    // Changing colours crosses no threshold.
    std::fill_n(v.begin(), splat::kSh * kExtremeCount, 0);
    EXPECT_LE((GradientError<B>(backend, problem, x, v, 1e-6)), 1e-5);
  }
}

template <class B>
void CheckSolves(const ExtremeProblem& c, std::initializer_list<JacobianKind> kinds) {
  for (const JacobianKind kind : kinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    RingProblem<typename B::Scalar> ring = ProblemOf<typename B::Scalar>(c);
    ring.options.jacobian = kind;
    const LmSummary summary = SolveAndCheck<B>(ring, FewIterations());
    EXPECT_TRUE(c.fits || summary.num_accepted > 0) << summary.FullReport();
  }
}

}  // namespace vesta::gs::test
