// SPDX-License-Identifier: Apache-2.0
// Linear maps composed of other maps: products, row scaling and column scaling. For example, the Jacobian of Gaussian
// splatting is the product of the derivatives of loss, rasterisation and projection.
#pragma once

#include "solver/linear_operator.h"
#include "solver/problem.h"

namespace vesta {

// The Jacobian J of a linearization, which must outlive this object.
template <Backend B>
class JacobianMap final : public LinearMap<B> {
 public:
  explicit JacobianMap(Linearization<B>& linearization) : linearization_(linearization) {}
  Index rows() const override { return linearization_.num_residuals(); }
  Index cols() const override { return linearization_.num_parameters(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override { linearization_.ApplyJ(x, y); }
  void ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) override { linearization_.ApplyJT(y, x); }

 private:
  Linearization<B>& linearization_;
};

// The product outer * inner; outer.cols() must equal inner.rows(). Both maps must outlive this object.
template <Backend B>
class ProductMap final : public LinearMap<B> {
 public:
  ProductMap(LinearMap<B>& outer, LinearMap<B>& inner);
  Index rows() const override { return outer_.rows(); }
  Index cols() const override { return inner_.cols(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;
  void ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) override;

 private:
  LinearMap<B>&outer_, &inner_;
  typename B::Vector between_;
};

// The map diag(d) A. d has rows() entries; d and A must outlive this object.
template <Backend B>
class ScaledRows final : public LinearMap<B> {
 public:
  ScaledRows(typename B::ConstVectorView d, LinearMap<B>& a);
  Index rows() const override { return a_.rows(); }
  Index cols() const override { return a_.cols(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;
  void ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) override;

 private:
  typename B::ConstVectorView d_;
  LinearMap<B>& a_;
  typename B::Vector work_;
};

// The map A diag(d). An entry 0 of d sets a column of A to zero; an entry 1 keeps the column. d has cols() entries; d
// and A must outlive this object.
template <Backend B>
class ScaledColumns final : public LinearMap<B> {
 public:
  ScaledColumns(LinearMap<B>& a, typename B::ConstVectorView d);
  Index rows() const override { return a_.rows(); }
  Index cols() const override { return a_.cols(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;
  void ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) override;

 private:
  LinearMap<B>& a_;
  typename B::ConstVectorView d_;
  typename B::Vector work_;
};

}  // namespace vesta
