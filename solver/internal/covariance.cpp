#include "solver/covariance.h"

#include <cmath>
#include <memory>
#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/linear/dense_qr.h"
#include "solver/internal/normal_equations/dense_jacobian.h"
#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

Covariance EstimateCovariance(Problem<CpuBackend<double>>& of, CpuBackend<double>::ConstVectorView x,
                              const CovarianceOptions& options) {
  constexpr Index kMaxEntries = 100'000'000;
  VESTA_CHECK(options.relative_threshold >= 0 && options.relative_threshold < 1, "relative_threshold is {}",
              options.relative_threshold);
  const ProblemAdaptor<CpuBackend<double>> problem(of);
  CpuBackend<double> backend;
  std::vector<std::unique_ptr<LinearizationAdaptor<CpuBackend<double>>>> batches;
  std::vector<LinearizationAdaptor<CpuBackend<double>>*> pointers;
  Index rows = 0;
  for (int b = 0; b < problem.num_batches(); ++b) {
    batches.push_back(problem.CheckedLinearize(x, b));
    pointers.push_back(batches.back().get());
    if (batches.back()->weighted()) Fail("a covariance needs a problem without weights W");
    rows += batches.back()->num_residuals();
  }
  if (rows * problem.num_tangent() > kMaxEntries) {
    Fail("a covariance needs the dense Jacobian, here {} x {}: too large", rows, problem.num_tangent());
  }
  const DenseJacobian dense = MakeDenseJacobian<CpuBackend<double>>(backend, pointers);
  Covariance covariance{.size = dense.cols};
  for (const double entry : dense.jacobian) {
    if (!std::isfinite(entry)) return covariance;
  }
  DenseQr::Inverse inverse = DenseQr(dense.rows, dense.cols, dense.jacobian, dense.residuals)
                                 .NormalInverse(options.relative_threshold, options.truncate);
  covariance.rank = inverse.rank;
  covariance.values = std::move(inverse.values);
  return covariance;
}

}  // namespace vesta
