// SPDX-License-Identifier: Apache-2.0
// A least-squares problem: two small base classes that the user implements, Problem and Linearization. All further
// interfaces are optional (solver/problem_interfaces.h).
//
// The engine minimises Cost(x) = 1/2 |r(x)|^2 with the residuals r(x). It uses products with the Jacobian J of r, and
// never forms J. The example below uses Multiply(x, y, out), which sets out_k = x_k y_k, and Axpby(a, x, b, y), which
// sets y = a x + b y. Its residuals are r_k = x_k^2 - c_k, so J = diag(2 x).
//
//   using B = vesta::CpuBackend<double>;
//   struct RootsAtX final : vesta::Linearization<B> {
//     RootsAtX(ConstVectorView at, const std::vector<double>& c) : x(at), r(at.size()) {
//       for (vesta::Index k = 0; k < x.size(); ++k) r[k] = x[k] * x[k] - c[k];
//     }
//     vesta::Index num_residuals() const override { return r.size(); }
//     vesta::Index num_parameters() const override { return x.size(); }
//     ConstVectorView residuals() const override { return r; }
//     void ApplyJ(ConstVectorView v, VectorView u) override { B().Multiply(x, v, u), B().Axpby(2, u, 0, u); }
//     void ApplyJT(ConstVectorView u, VectorView g) override { ApplyJ(u, g); }  // J is symmetric
//     void DiagJTJ(VectorView d) override { B().Multiply(x, x, d), B().Axpby(4, d, 0, d); }
//     ConstVectorView x;
//     B::Vector r;
//   };
//   struct Roots final : vesta::Problem<B> {
//     vesta::Index num_parameters() const override { return c.size(); }
//     double Cost(ConstVectorView x) override { ... 0.5 * the sum of (x_k^2 - c_k)^2 ... }
//     std::unique_ptr<vesta::Linearization<B>> Linearize(ConstVectorView x) override {
//       return std::make_unique<RootsAtX>(x, c);
//     }
//     std::vector<double> c;
//   };
//   ... vesta::SolveLm(problem, x) ...
#pragma once

#include <memory>

#include "kernels/core/error.h"
#include "kernels/core/vector_backend.h"

namespace vesta {

// A problem linearized at one x. Its sizes never change.
template <Backend B>
class Linearization {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;
  virtual ~Linearization() = default;

  virtual Index num_residuals() const = 0;
  // Columns of J: the number of entries of a step.
  virtual Index num_parameters() const = 0;
  // The residuals r at x. Valid as long as this object.
  virtual ConstVectorView residuals() const = 0;
  // u = J v: v has num_parameters() entries, u num_residuals(). Overwrites u.
  virtual void ApplyJ(ConstVectorView v, VectorView u) = 0;
  // g = J^T u: u has num_residuals() entries, g num_parameters(). Overwrites g.
  virtual void ApplyJT(ConstVectorView u, VectorView g) = 0;
  // d_k = (J^T J)_kk, or an estimate of its magnitude; with weights W (WithLossWeights): (J^T W J)_kk. d has
  // num_parameters() entries. Overwrites d.
  virtual void DiagJTJ(VectorView d) = 0;
};

// A least-squares problem: its cost, and its linearization at any x.
template <Backend B>
class Problem {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;
  virtual ~Problem() = default;

  // Number of entries of x.
  virtual Index num_parameters() const = 0;
  // The cost at x over all residuals (all batches). If the cost is undefined at x, returns NaN or infinity and does not
  // throw; a step to x is then rejected.
  virtual double Cost(ConstVectorView x) = 0;
  // Linearizes at x; must not return null. x does not change while the linearization exists. If a derivative is NaN or
  // infinite, the solve ends as LmStatus::kNonFinite.
  virtual std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) = 0;

 protected:
  // Throws Error unless x has num_parameters() entries.
  void CheckSize(ConstVectorView x) const;
};

}  // namespace vesta
