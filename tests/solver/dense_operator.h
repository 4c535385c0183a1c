// SPDX-License-Identifier: Apache-2.0
// Small dense matrices as operators, for tests of the solver.
#pragma once

#include <Eigen/Dense>
#include <utility>

#include "solver/linear_operator.h"
#include "tests/support/dense_reference.h"

namespace vesta {

using Cpu = CpuBackend<double>;

inline Eigen::Map<const Eigen::VectorXd> AsEigen(Cpu::ConstVectorView x) { return {x.data(), x.size()}; }
inline Eigen::Map<Eigen::VectorXd> AsEigen(Cpu::VectorView x) { return {x.data(), x.size()}; }

class DenseOperator final : public LinearOperator<Cpu> {
 public:
  explicit DenseOperator(Eigen::MatrixXd a) : a_(std::move(a)) {}
  Index size() const override { return a_.rows(); }
  void Apply(Cpu::ConstVectorView x, Cpu::VectorView y) override {
    AsEigen(y) = test::Apply(a_, AsEigen(x));
    ++applications;
  }
  int applications = 0;

 private:
  Eigen::MatrixXd a_;
};

class DenseMap final : public LinearMap<Cpu> {
 public:
  explicit DenseMap(Eigen::MatrixXd a) : a_(std::move(a)) {}
  Index rows() const override { return a_.rows(); }
  Index cols() const override { return a_.cols(); }
  void Apply(Cpu::ConstVectorView x, Cpu::VectorView y) override { AsEigen(y) = test::Apply(a_, AsEigen(x)); }
  void ApplyAdjoint(Cpu::ConstVectorView y, Cpu::VectorView x) override {
    AsEigen(x) = test::ApplyTransposed(a_, AsEigen(y));
  }

 private:
  Eigen::MatrixXd a_;
};

inline Cpu::Vector Vector(std::initializer_list<double> values) {
  Cpu::Vector v(static_cast<Index>(values.size()));
  std::copy(values.begin(), values.end(), v.begin());
  return v;
}

}  // namespace vesta
