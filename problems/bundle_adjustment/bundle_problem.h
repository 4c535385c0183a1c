// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment as a problem of the engine: x is the cameras, nine parameters each, then the points, three each.
#pragma once

#include <memory>

#include "kernels/core/cpu_dispatch.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/structure.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/problem.h"

namespace vesta::bundle {

// The precision in which the Jacobian is stored. Arithmetic, residuals and gradient are in double with either.
enum class JacobianStorage { kDouble, kFloat };

// How products with the reduced system (cameras alone, points eliminated) are made.
enum class ReducedForm {
  kAuto,      // explicit where forming the matrix costs no more than some twenty implicit products
  kImplicit,  // through the Jacobian, one pass over the observations a product
  kExplicit,  // by the blocks of the matrix, formed once for each damping
};

struct BundleProblemOptions {
  // The loss on each observation's squared reprojection error; null: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  JacobianStorage storage = JacobianStorage::kDouble;
  ReducedForm reduced_form = ReducedForm::kAuto;
  // Whether the explicit form is factorised, where that costs no more than some hundred products with it.
  bool factorize_reduced = true;
  // Instruction set of the passes; the CPU must have it.
  Isa isa = ActiveIsa();
};

// Options of the engine that suit bundle adjustments: points eliminated, conjugate gradients on the cameras, a soft
// rule for the damping.
LmOptions BundleLmOptions();

namespace internal {
struct BundleContext;
}

class BundleProblem final : public Problem<CpuBackend<double>> {
 public:
  // Copies what it needs of data. Throws Error where the data do not fit together.
  explicit BundleProblem(const BundleData& data, BundleProblemOptions options = {});
  ~BundleProblem() override;

  Index num_parameters() const override;
  double Cost(ConstVectorView x) override;
  // The problem must outlive what it returns. Residuals are in the order of points, then cameras, two each.
  std::unique_ptr<Linearization<CpuBackend<double>>> Linearize(ConstVectorView x) override;

  const Structure& structure() const;
  // Sum of squared reprojection errors over all observations, pixels squared, without the loss.
  double SquaredError(ConstVectorView x);

 private:
  // The sum over all observations, in a fixed order, of term(count, squared norms), called with some of them at a time.
  template <class Term>
  double SumOverSlices(ConstVectorView x, const Term& term);

  std::unique_ptr<internal::BundleContext> context_;
};

}  // namespace vesta::bundle
