// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment as a least-squares problem. x has nine parameters per camera (projection.h), then three coordinates
// per point.
#pragma once

#include <memory>

#include "kernels/core/cpu_dispatch.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/structure.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/problem.h"

namespace vesta::bundle {

// Precision of the stored Jacobian. Arithmetic, residuals and gradient are always double.
enum class JacobianStorage { kDouble, kFloat };

// Products with the matrix of the reduced system: the system of the cameras after elimination of the points.
enum class ReducedForm {
  kAuto,      // explicit if forming the matrix takes at most the time of about twenty implicit products
  kImplicit,  // each product uses the Jacobian, in one pass over the observations
  kExplicit,  // each product uses the blocks of the matrix, which are formed once per damping value
};

struct BundleProblemOptions {
  // Robust loss of each squared reprojection error; null: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  JacobianStorage storage = JacobianStorage::kDouble;
  ReducedForm reduced_form = ReducedForm::kAuto;
  // Explicit form only: preconditions with a sparse Cholesky factor, if the factor takes at most the time of about a
  // hundred products with the matrix.
  bool factorize_reduced = true;
  // Instruction set of the passes; the CPU must support it.
  Isa isa = ActiveIsa();
};

// Solver options for bundle adjustment: points are eliminated, and PCG solves the reduced system.
LmOptions BundleLmOptions();

namespace internal {
struct BundleContext;
}

class BundleProblem final : public Problem<CpuBackend<double>> {
 public:
  // Copies the data. Throws Error if sizes are inconsistent or an index is out of range.
  explicit BundleProblem(const BundleData& data, BundleProblemOptions options = {});
  ~BundleProblem() override;

  Index num_parameters() const override;
  double Cost(ConstVectorView x) override;
  // The problem must outlive the result. Two residuals per observation, in track order (kernels.h).
  std::unique_ptr<Linearization<CpuBackend<double>>> Linearize(ConstVectorView x) override;

  const Structure& structure() const;
  // Sum of squared reprojection errors, in pixels squared, without the robust loss.
  double SquaredError(ConstVectorView x);

 private:
  // Sums term(count, squared norms of the residuals) over slices of the observations, in a fixed order.
  template <class Term>
  double SumOverSlices(ConstVectorView x, const Term& term);

  std::unique_ptr<internal::BundleContext> context_;
};

}  // namespace vesta::bundle
