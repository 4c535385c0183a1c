// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment as a least-squares problem: x holds nine parameters per camera, then three per point.
#pragma once

#include <memory>

#include "kernels/core/cpu_dispatch.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/structure.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/problem.h"

namespace vesta::bundle {

// Precision of the stored Jacobian. Arithmetic, residuals and gradient are always in double.
enum class JacobianStorage { kDouble, kFloat };

// How products with the reduced system are computed (the system of the cameras, with points eliminated).
enum class ReducedForm {
  kAuto,      // explicit if forming the matrix costs no more than some twenty implicit products
  kImplicit,  // through the Jacobian, with one pass over the observations per product
  kExplicit,  // with the blocks of the matrix, formed once per damping value
};

struct BundleProblemOptions {
  // Loss of each observation's squared reprojection error; null: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  JacobianStorage storage = JacobianStorage::kDouble;
  ReducedForm reduced_form = ReducedForm::kAuto;
  // Factorises the explicit form if that costs no more than about a hundred products with it.
  bool factorize_reduced = true;
  // Instruction set of the passes; the CPU must support it.
  Isa isa = ActiveIsa();
};

// Solver options that suit bundle adjustment: points are eliminated, and conjugate gradients solve for the cameras.
LmOptions BundleLmOptions();

namespace internal {
struct BundleContext;
}

class BundleProblem final : public Problem<CpuBackend<double>> {
 public:
  // Copies the data. Throws Error if the data are inconsistent.
  explicit BundleProblem(const BundleData& data, BundleProblemOptions options = {});
  ~BundleProblem() override;

  Index num_parameters() const override;
  double Cost(ConstVectorView x) override;
  // The problem must outlive the result. Residuals are sorted by track (kernels.h), then by camera, two per
  // observation.
  std::unique_ptr<Linearization<CpuBackend<double>>> Linearize(ConstVectorView x) override;

  const Structure& structure() const;
  // Sum of squared reprojection errors over all observations, in pixels squared, without the loss.
  double SquaredError(ConstVectorView x);

 private:
  // Sums term(count, squared norms) over slices of the observations, in a fixed order.
  template <class Term>
  double SumOverSlices(ConstVectorView x, const Term& term);

  std::unique_ptr<internal::BundleContext> context_;
};

}  // namespace vesta::bundle
