// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/training/lens_steps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <type_traits>

#include "kernels/core/check.h"
#include "splatting/cameras/derivatives/step_system.h"

namespace vesta::gs {
namespace {

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

// H = [own, coupling^T; coupling, lens] of a view, its own part solvable.
struct Parts {
  StepMatrix own, coupling, lens;

  Parts(const FreeUnknowns& free, const std::vector<double>& curvature) {
    const Eigen::Index n = free.num_tangent(), of_view = free.OwnOfView().num_tangent();
    VESTA_CHECK(free.lens && curvature.size() == static_cast<std::size_t>(n * n),
                "a curvature of {} numbers for a step of {}, the lens's included", curvature.size(), n);
    const StepMatrix H = StepMatrixOf(curvature);
    own = Damped(H.topLeftCorner(of_view, of_view));
    coupling = H.bottomLeftCorner(n - of_view, of_view);
    lens = H.bottomRightCorner(n - of_view, n - of_view);
  }
};

}  // namespace

void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system) {
  const Parts H(free, curvature);
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

std::vector<double> Follow(const FreeUnknowns& free, const std::vector<double>& curvature,
                           const splat::LensTangent& lens) {
  const Parts H(free, curvature);
  const Eigen::Map<const StepVector> of_lens(lens.v, free.lens_tangent());
  StepVector own = -H.own.ldlt().solve(StepVector(H.coupling.transpose() * of_lens));
  if (!own.allFinite()) own.setZero();
  std::vector<double> step(own.begin(), own.end());
  step.insert(step.end(), lens.v, lens.v + free.lens_tangent());
  return step;
}

}  // namespace vesta::gs
