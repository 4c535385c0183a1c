// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/derivatives/view_problem.h"

#include <gtest/gtest.h>

#include "kernels/core/error.h"
#include "solver/check_problem.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "tests/splatting/cameras/perturbed_view.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs {
namespace {

constexpr FreeUnknowns kKinds[] = {{.pose = true, .color = false}, {.pose = false, .color = true}, {true, true}};

// In precision S, with its image and a perturbed start.
template <class S>
struct ViewAndStart {
  SplatModel model = test::RandomModel(60, 2, 1);
  View view;
  std::vector<S> x, truth;
  splat::Model<S> kernel_model;
  TargetView<CpuBackend<S>> target;
  HostBuffer<double> at;

  ViewAndStart() : at(kViewParameters) {
    view = test::RingWithImages(model, 3, 40, 30).views[1];
    x.assign(model.data.begin(), model.data.end());
    truth.assign(view.image.rgb.begin(), view.image.rgb.end());
    kernel_model = {x.data(), model.count, model.sh_degree, model.sh_degree};
    target = {ToPosedCamera(view, 0.01), {truth.data(), static_cast<Index>(truth.size())}};
    Pack({test::RandomMotion(1, 0.02, 2), {{0.9, 1.1, 1.05}, {0.01, -0.02, 0.03}}}, at);
  }
  ViewProblem<S> Make(const FreeUnknowns& free) const {
    return ViewProblem<S>({free, {0.2, 0.5, 0.9}, {}}, kernel_model, target);
  }
};

// CheckProblem: products, curvature, the gradient along Plus, and blocks.
void ExpectNoFault(const ViewAndStart<double>& setup) {
  for (const FreeUnknowns& free : kKinds) {
    ViewProblem<double> problem = setup.Make(free);
    EXPECT_EQ(problem.num_tangent(), (free.pose ? 6 : 0) + (free.color ? 6 : 0));
    CpuBackend<double> backend;
    const ProblemCheck check = CheckProblem<CpuBackend<double>>(backend, problem, setup.at);
    EXPECT_TRUE(check.ok()) << check.Report();
  }
}

TEST(ViewProblem, HasNoFault) { ExpectNoFault({}); }

TEST(ViewProblem, HasNoFaultWherePixelsDoNotCount) {
  ViewAndStart<double> setup;
  std::vector<std::uint8_t> mask(40 * 30);
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 40 < 25 ? 1 : 0;
  setup.target.mask = {mask.data(), static_cast<Index>(mask.size())};
  ExpectNoFault(setup);
}

// CheckProblem skips J for weighted problems, so columns are compared with differences.
TEST(ViewProblem, ColumnsAreDerivativesOfTheResiduals) {
  const ViewAndStart<double> setup;
  ViewProblem<double> problem = setup.Make({true, true});
  const auto linearization = LinearizeAt(problem, setup.at);
  const Index n = linearization->num_residuals();
  HostBuffer<double> delta(12), moved(kViewParameters), column(n);
  CpuBackend<double> backend;
  const auto residuals = [&](int k, double step) {
    delta.Resize(12);
    delta[k] = step;
    problem.Plus(backend, setup.at, delta, moved);
    const auto there = LinearizeAt(problem, moved);
    return std::vector<double>(there->residuals().begin(), there->residuals().end());
  };
  for (int k = 0; k < 12; ++k) {
    const std::vector<double> above = residuals(k, 1e-6), below = residuals(k, -1e-6);
    delta.Resize(12);
    delta[k] = 1;
    linearization->ApplyJ(delta, column);
    double scale = 0;
    int beyond = 0;
    for (const double value : column) scale = std::max(scale, std::abs(value));
    ASSERT_GT(scale, 0.1) << k;
    for (Index i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      beyond += std::abs((above[at] - below[at]) / 2e-6 - column[i]) > 1e-4 * scale ? 1 : 0;
    }
    // exceptions: an alpha crosses 1/255 between the two points
    EXPECT_LE(beyond, 3) << k;
  }
}

// Against differences of images. A single view is no problem with a lens.
TEST(ViewColumns, OfALensAreDerivativesOfTheImage) {
  const ViewAndStart<double> setup;
  constexpr FreeUnknowns kLens{.pose = false, .color = false, .lens = true};
  const double background[] = {0.2, 0.5, 0.9};
  const auto render = [&](const LensChange& lens, splat::SplatView<double>* view,
                          splat::ViewWorkspace<double>* workspace) {
    HostBuffer<double> image(setup.target.shape().NumValues());
    view->Build(setup.kernel_model, AsFound(setup.target.camera, {.lens = lens}), background, *workspace);
    view->Render(image.data());
    return image;
  };
  splat::SplatView<double> view, moved;
  splat::ViewWorkspace<double> workspace;
  const HostBuffer<double> image = render({}, &view, &workspace);
  const ViewColumns<CpuBackend<double>> columns = ColumnsOf<CpuBackend<double>>(
      kLens, {}, setup.target, image.view(),
      CameraDerivativeImages<CpuBackend<double>>(kLens, view, setup.kernel_model, workspace).view());
  ASSERT_EQ(columns.num_images(), 4);
  for (int k = 0; k < 4; ++k) {
    splat::LensTangent step;
    const auto stepped = [&](double by) {
      step.v[k] = by;
      return render(Compose(step, {}), &moved, &workspace);
    };
    const HostBuffer<double> above = stepped(1e-6), below = stepped(-1e-6);
    const HostSpan<const double> column = columns.image(k);
    double scale = 0;
    int beyond = 0;
    for (const double value : column) scale = std::max(scale, std::abs(value));
    ASSERT_GT(scale, 0.1) << k;
    for (Index i = 0; i < image.size(); ++i)
      beyond += std::abs((above[i] - below[i]) / 2e-6 - column[i]) > 1e-4 * scale;
    EXPECT_LE(beyond, 3) << k;  // an alpha crosses 1/255 between the two points
  }
}

TEST(ViewProblem, InFloatIsThatInDouble) {
  const ViewAndStart<double> exact;
  const ViewAndStart<float> rounded;
  ViewProblem<double> a = exact.Make({true, true});
  ViewProblem<float> b = rounded.Make({true, true});
  EXPECT_NEAR(b.Cost(rounded.at), a.Cost(exact.at), 1e-5 * a.Cost(exact.at));
  HostBuffer<double> g(12), expected(12), diagonal(12);
  const auto linearization = LinearizeAt(a, exact.at);
  linearization->Gradient(expected);
  linearization->DiagJTJ(diagonal);
  LinearizeAt(b, rounded.at)->Gradient(g);
  double norm = 0;
  for (int k = 0; k < 12; ++k) norm = std::max(norm, std::abs(expected[k]) / std::sqrt(diagonal[k]));
  for (int k = 0; k < 12; ++k) EXPECT_NEAR(g[k], expected[k], 1e-3 * norm * std::sqrt(diagonal[k])) << k;
}

TEST(ViewProblem, RefusesWhatIsNoProblem) {
  const ViewAndStart<float> setup;
  EXPECT_THROW(setup.Make({false, false}), Error);
  EXPECT_NO_THROW(setup.Make({true, true}));
  EXPECT_THROW(setup.Make({true, true, true}), Error) << "a lens";
  TargetView<CpuBackend<float>> target = setup.target;
  target.truth = target.truth.subspan(0, target.truth.size() - 1);
  EXPECT_THROW(ViewProblem<float>({}, setup.kernel_model, target), Error);
}

TEST(ViewUnknowns, KeepTheirPlaces) {
  ViewUnknowns unknowns{test::RandomMotion(5, 1, 3), {{0.5, 0.6, 0.7}, {0.1, 0.2, 0.3}}};
  HostBuffer<double> x(kViewParameters), delta(6);
  Pack(unknowns, x);
  const ViewUnknowns back = Unpack(x);
  EXPECT_EQ(back.color.gain, unknowns.color.gain);
  EXPECT_EQ(back.color.offset, unknowns.color.offset);
  for (int i = 0; i < 6; ++i) delta[i] = 0.01 * i;
  const ViewUnknowns colored = Plus(unknowns, {.pose = false, .color = true}, delta);
  EXPECT_EQ(colored.motion.Angle(), unknowns.motion.Angle());
  EXPECT_DOUBLE_EQ(colored.color.gain[2], 0.72);
  EXPECT_DOUBLE_EQ(colored.color.offset[0], 0.13);
  const ViewUnknowns moved = Plus(unknowns, {.pose = true, .color = false}, delta);
  EXPECT_EQ(moved.color.gain, unknowns.color.gain);
  EXPECT_NE(moved.motion.Angle(), unknowns.motion.Angle());
  EXPECT_THROW(Plus(unknowns, {true, true}, delta), Error);
}

}  // namespace
}  // namespace vesta::gs
