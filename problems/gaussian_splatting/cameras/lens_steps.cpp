#include "problems/gaussian_splatting/cameras/lens_steps.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/cameras/step_system.h"

namespace vesta::gs {
namespace {

using LensVector = Eigen::Matrix<double, splat::kLensTangent, 1>;
using LensMatrix = Eigen::Matrix<double, splat::kLensTangent, splat::kLensTangent, Eigen::RowMajor>;

// H = [own, coupling^T; coupling, lens] of a view, its own part solvable.
struct Parts {
  StepMatrix own, coupling;
  LensMatrix lens;

  Parts(const FreeUnknowns& free, const std::vector<double>& curvature) {
    const Eigen::Index n = free.num_tangent(), of_view = free.OwnOfView().num_tangent();
    VESTA_CHECK(free.lens && curvature.size() == static_cast<std::size_t>(n * n),
                "a curvature of {} numbers for a step of {}, the lens's included", curvature.size(), n);
    const StepMatrix H = StepMatrixOf(curvature);
    own = Damped(H.topLeftCorner(of_view, of_view));
    coupling = H.bottomLeftCorner(splat::kLensTangent, of_view);
    lens = H.bottomRightCorner<splat::kLensTangent, splat::kLensTangent>();
  }
};

}  // namespace

void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system) {
  const Parts H(free, curvature);
  const auto solver = H.own.ldlt();
  const Eigen::Map<const StepVector> g(gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  const LensVector of_lens =
      g.tail<splat::kLensTangent>() - H.coupling * solver.solve(StepVector(g.head(H.own.rows())));
  const LensMatrix schur = H.lens - H.coupling * solver.solve(StepMatrix(H.coupling.transpose()));
  if (!of_lens.allFinite() || !schur.allFinite()) return;
  Eigen::Map<LensVector>(system->gradient.data()) += of_lens;
  Eigen::Map<LensMatrix>(system->curvature.data()) += schur;
  ++system->views;
}

splat::LensTangent LensStep(const LensSystem& system, double part, double most) {
  const StepMatrix H = Damped(Eigen::Map<const LensMatrix>(system.curvature.data()));
  const LensVector step = -part * H.ldlt().solve(Eigen::Map<const LensVector>(system.gradient.data()));
  splat::LensTangent lens;
  const double largest = step.cwiseAbs().maxCoeff();
  if (!step.allFinite() || largest == 0) return lens;
  Eigen::Map<LensVector>(lens.v) = step * std::min(1.0, most / largest);
  return lens;
}

std::vector<double> Follow(const FreeUnknowns& free, const std::vector<double>& curvature,
                           const splat::LensTangent& lens) {
  const Parts H(free, curvature);
  const Eigen::Map<const LensVector> of_lens(lens.v);
  const StepVector own = -H.own.ldlt().solve(StepVector(H.coupling.transpose() * of_lens));
  std::vector<double> step(own.begin(), own.end());
  step.insert(step.end(), lens.v, lens.v + splat::kLensTangent);
  return step;
}

}  // namespace vesta::gs
