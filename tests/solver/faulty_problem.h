// SPDX-License-Identifier: Apache-2.0
// A linear problem with three parameters and a configurable mistake in one of its functions.
#pragma once

#include <functional>
#include <memory>

#include "solver/problem_interfaces.h"
#include "tests/solver/dense_operator.h"

namespace vesta {

class FaultyProblem final : public Problem<Cpu>, public OnManifold<Cpu> {
 public:
  // Each function is called after the correct result has been written, and may change it.
  std::function<void(Cpu::VectorView d)> on_diagonal;
  std::function<void(Cpu::ConstVectorView u, Cpu::VectorView g)> on_transpose;
  std::function<void(Cpu::ConstVectorView v, Cpu::VectorView u)> on_jacobian;
  std::function<void(Cpu::VectorView g)> on_gradient;
  std::function<void(Cpu::ConstVectorView v, Cpu::VectorView Hv)> on_product;
  std::function<void(Cpu::VectorView values)> on_blocks;
  std::function<void(Cpu::ConstVectorView x, Cpu::ConstVectorView delta, Cpu::VectorView out)> on_plus;
  std::function<double(double cost)> on_cost;
  // These functions write no result at all.
  bool skips_diagonal = false, skips_transpose = false;
  bool gives_null = false;

  const Eigen::Matrix<double, 4, 3> a =
      (Eigen::Matrix<double, 4, 3>() << 2, 0.5, 0, 0, 1, -0.3, 0.2, 0, 3, 1, 1, 1).finished();
  const Eigen::Vector4d b{1, -2, 0.5, 4};

  Index num_parameters() const override { return 3; }
  double Cost(Cpu::ConstVectorView x) override {
    const double cost = 0.5 * (a * AsEigen(x) - b).squaredNorm();
    return on_cost ? on_cost(cost) : cost;
  }
  std::unique_ptr<Linearization<Cpu>> Linearize(Cpu::ConstVectorView x) override {
    return gives_null ? nullptr : std::make_unique<At>(*this, x);
  }
  Index num_tangent() const override { return 3; }
  void Plus(Cpu& backend, Cpu::ConstVectorView x, Cpu::ConstVectorView delta, Cpu::VectorView out) override {
    backend.Copy(x, out);
    backend.Axpby(1, delta, 1, out);
    if (on_plus) on_plus(x, delta, out);
  }

 private:
  class At final : public Linearization<Cpu>,
                   public WithGradient<Cpu>,
                   public WithProductH<Cpu>,
                   public WithBlocks<Cpu> {
   public:
    At(const FaultyProblem& problem, Cpu::ConstVectorView x) : problem_(problem), residuals_(4) {
      AsEigen(residuals_.view()) = problem.a * AsEigen(x) - problem.b;
    }
    Index num_residuals() const override { return 4; }
    Index num_parameters() const override { return 3; }
    Cpu::ConstVectorView residuals() const override { return residuals_.view(); }
    void ApplyJ(Cpu::ConstVectorView v, Cpu::VectorView u) override {
      AsEigen(u) = problem_.a * AsEigen(v);
      if (problem_.on_jacobian) problem_.on_jacobian(v, u);
    }
    void ApplyJT(Cpu::ConstVectorView u, Cpu::VectorView g) override {
      if (problem_.skips_transpose) return;
      AsEigen(g) = problem_.a.transpose() * AsEigen(u);
      if (problem_.on_transpose) problem_.on_transpose(u, g);
    }
    void DiagJTJ(Cpu::VectorView d) override {
      if (problem_.skips_diagonal) return;
      AsEigen(d) = problem_.a.colwise().squaredNorm().transpose();
      if (problem_.on_diagonal) problem_.on_diagonal(d);
    }
    void Gradient(Cpu::VectorView g) override {
      ApplyJT(residuals_, g);
      if (problem_.on_gradient) problem_.on_gradient(g);
    }
    void ApplyH(Cpu::ConstVectorView v, Cpu::VectorView Hv) override {
      Cpu::Vector Jv(4);
      ApplyJ(v, Jv);
      ApplyJT(Jv, Hv);
      if (problem_.on_product) problem_.on_product(v, Hv);
    }
    std::vector<BlockGroup> block_groups() const override {
      return {{.size = 3, .count = 1, .offset = 0, .component_stride = 1, .block_stride = 3}};
    }
    void BlockGram(BlockDiagonal<Cpu>& blocks) override {
      const Eigen::Matrix3d h = problem_.a.transpose() * problem_.a;
      for (int row = 0; row < 3; ++row) {
        for (int col = 0; col <= row; ++col) blocks.values(0)[PackedLower(row, col)] = h(row, col);
      }
      if (problem_.on_blocks) problem_.on_blocks(blocks.values(0));
    }

   private:
    const FaultyProblem& problem_;
    Cpu::Vector residuals_;
  };
};

}  // namespace vesta
