#include "problems/gaussian_splatting/cameras/view_curvature.h"

namespace vesta::gs {

std::vector<double> ViewCurvature(const ViewProblemOptions& options, const splat::Model<float>& model,
                                  const TargetView<CpuBackend<float>>& target) {
  ViewProblem<float> problem(options, model, target);
  HostBuffer<double> x(kViewParameters);
  Pack({}, x.view());
  const auto linearization = problem.Linearize(x.view(), 0);
  const Index n = problem.num_tangent();
  std::vector<double> H(static_cast<std::size_t>(n * n)), unit(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    std::fill(unit.begin(), unit.end(), 0.0);
    unit[static_cast<std::size_t>(i)] = 1;
    linearization->ApplyH({unit.data(), n}, {H.data() + i * n, n});
  }
  return H;
}

}  // namespace vesta::gs
