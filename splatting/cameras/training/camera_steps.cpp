// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/training/camera_steps.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/alignment/align_view.h"

namespace vesta::gs {
namespace {

// Fixed-capacity vectors and matrices for the step systems of views and lenses.
constexpr int kMostStepNumbers = FreeUnknowns{true, true, true}.num_tangent();
using StepVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStepNumbers, 1>;
using StepMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMostStepNumbers, kMostStepNumbers>;

// square: the matrix, row-major.
StepMatrix StepMatrixOf(const std::vector<double>& square) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(square.size())));
  return Eigen::Map<const StepMatrix>(square.data(), n, n);
}

// Multiplies the diagonal by 1 + damping, which separates unknowns such as a rotation and a shift. Entries that are not
// positive (undetermined unknowns) become 1.
StepMatrix Damped(StepMatrix H) {
  constexpr double kDamping = 1e-3;
  for (Eigen::Index i = 0; i < H.rows(); ++i) H(i, i) = H(i, i) > 0 ? H(i, i) * (1 + kDamping) : 1;
  return H;
}

template <class System>
auto CurvatureOf(System& system) {
  return Eigen::Map<std::conditional_t<std::is_const_v<System>, const StepMatrix, StepMatrix>>(
      system.curvature.data(), splat::kLensTangent, splat::kLensTangent);
}
template <class System>
auto GradientOf(System& system) {
  return Eigen::Map<std::conditional_t<std::is_const_v<System>, const StepVector, StepVector>>(system.gradient.data(),
                                                                                               splat::kLensTangent);
}

// The curvature of a view split into its own unknowns and the lens: H = [own, coupling^T; coupling, lens]. The own part
// is damped, so it can be solved.
struct SplitSystem {
  StepMatrix own, coupling, lens;

  SplitSystem(const FreeUnknowns& free, const std::vector<double>& curvature) {
    const Eigen::Index n = free.num_tangent(), of_view = free.OwnOfView().num_tangent();
    VESTA_CHECK(free.lens && curvature.size() == static_cast<std::size_t>(n * n),
                "a curvature of {} numbers for a step of {}, the lens's included", curvature.size(), n);
    const StepMatrix H = StepMatrixOf(curvature);
    own = Damped(H.topLeftCorner(of_view, of_view));
    coupling = H.bottomLeftCorner(n - of_view, of_view);
    lens = H.bottomRightCorner(n - of_view, n - of_view);
  }
};

// Thresholds: relative decrease of the loss by poses, and of the error by exposures.
constexpr double kPoseGain = 0.1, kExposureGain = 0.05;

AlignedEvaluation Fit(const SplatModel& model, const Scene& scene, AlignOptions options, bool color) {
  options.free.color = color;
  return EvaluateAligned(model, scene, options);
}

}  // namespace

void RescaleCurvature(double pixels, CameraStepState* state) {
  if (state->curvature.empty() || state->pixels == pixels) return;
  for (double& value : state->curvature) value *= pixels / state->pixels;
  state->pixels = pixels;
}

double GaussNewtonFactor(double done) {
  constexpr double kRest = 0.2, kAtEnd = 0.1;
  const double into_rest = done - (1 - kRest);
  return into_rest > 0 ? std::pow(kAtEnd, into_rest / kRest) : 1;
}

std::vector<double> CameraStep(const FreeUnknowns& free, const std::vector<double>& gradient,
                               const std::vector<double>& curvature, const CameraStepContext& around) {
  const Eigen::Index own = free.OwnOfView().num_tangent();
  VESTA_CHECK(curvature.size() == gradient.size() * gradient.size(), "a gradient of {} numbers, but a curvature of {}",
              gradient.size(), curvature.size());
  const StepMatrix H = Damped(StepMatrixOf(curvature).topLeftCorner(own, own));
  StepVector step =
      -GaussNewtonFactor(around.done) * H.ldlt().solve(Eigen::Map<const StepVector>(gradient.data(), own));
  if (!step.allFinite()) step.setZero();
  if (free.pose) {
    const double far = std::max(step.head<3>().norm(), step.segment<3>(3).norm() / around.depth);
    if (far > around.most) step *= around.most / far;
  }
  std::vector<double> whole(step.begin(), step.end());
  whole.resize(static_cast<std::size_t>(free.num_tangent()));
  return whole;
}

void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system) {
  const SplitSystem H(free, curvature);
  const auto solver = H.own.ldlt();
  const Eigen::Map<const StepVector> g(gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  const StepVector of_lens = g.tail(H.lens.rows()) - H.coupling * solver.solve(StepVector(g.head(H.own.rows())));
  const StepMatrix schur = H.lens - H.coupling * solver.solve(StepMatrix(H.coupling.transpose()));
  if (!of_lens.allFinite() || !schur.allFinite()) return;
  GradientOf(*system) += of_lens;
  CurvatureOf(*system) += schur;
  ++system->views;
}

splat::LensTangent LensStep(const LensSystem& system, double part, double most) {
  const StepMatrix H = Damped(CurvatureOf(system));
  const StepVector step = -part * H.ldlt().solve(GradientOf(system));
  splat::LensTangent lens;
  const double largest = step.cwiseAbs().maxCoeff();
  if (!step.allFinite() || largest == 0) return lens;
  Eigen::Map<StepVector>(lens.v, step.size()) = step * std::min(1.0, most / largest);
  return lens;
}

std::vector<double> FollowLensStep(const FreeUnknowns& free, const std::vector<double>& curvature,
                                   const splat::LensTangent& lens) {
  const SplitSystem H(free, curvature);
  const Eigen::Map<const StepVector> of_lens(lens.v, free.lens_tangent());
  StepVector own = -H.own.ldlt().solve(StepVector(H.coupling.transpose() * of_lens));
  if (!own.allFinite()) own.setZero();
  std::vector<double> step(own.begin(), own.end());
  step.insert(step.end(), lens.v, lens.v + free.lens_tangent());
  return step;
}

CameraChoice CameraEvidence::Choice() const { return pose >= kPoseGain ? CameraChoice::kPose : CameraChoice::kNone; }

std::string CameraEvidence::Summary() const {
  return fmt::format(
      "{} held-out views: their loss falls by {:.1f} % (threshold {:.0f} %) when their cameras move by {:.2f} pixels{}",
      views, 100 * pose, 100 * kPoseGain, pixels,
      exposure < kExposureGain
          ? ""
          : fmt::format("; their error falls by {:.0f} % with fitted exposures: the exposures of the "
                        "photographs seem to differ, try pose+exposure",
                        100 * exposure));
}

CameraEvidence EvidenceOf(const SplatModel& model, const std::vector<View>& views,
                          const std::array<double, 3>& background, double near) {
  Scene scene;
  scene.views = views;
  for (View& view : scene.views) view.role = ViewRole::kTest;
  AlignOptions options;
  options.background = background, options.near = near;
  const AlignedEvaluation moved = Fit(model, scene, options, false), exposed = Fit(model, scene, options, true);
  CameraEvidence evidence;
  std::vector<double> gains;
  for (const AlignedView& view : moved.views) {
    const Alignment& alignment = view.alignment;
    gains.push_back(alignment.is_found() ? 1 - alignment.cost_after / alignment.cost_before : 0);
  }
  evidence.views = static_cast<int>(views.size());
  if (views.empty()) return evidence;
  evidence.pose = Median(std::move(gains));
  evidence.pixels = moved.pixels;
  if (exposed.right.views > 0) {
    evidence.exposure = 1 - std::pow(10, (exposed.right.psnr - exposed.right_exposed.psnr) / 20);
  }
  return evidence;
}

}  // namespace vesta::gs
