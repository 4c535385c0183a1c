// SPDX-License-Identifier: Apache-2.0
// The reduced system agrees with dense algebra.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/derivative_check.h"
#include "solver/reduced_system.h"
#include "tests/problems/bundle_adjustment/small_problem.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/dense_reference.h"
#include "tests/support/linearize_at.h"

namespace vesta::bundle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigen::Map<VectorXd> AsEigen(Cpu::VectorView v) { return {v.data(), v.size()}; }

// H + lambda D as a dense matrix, from products with unit vectors.
MatrixXd DenseDamped(LinearizationAdaptor<Cpu>& linearization, double lambda, Cpu::VectorView metric) {
  const Index n = linearization.num_parameters();
  MatrixXd jacobian(linearization.num_residuals(), n);
  Cpu::Vector unit(n), column(jacobian.rows());
  for (Index k = 0; k < n; ++k) {
    unit[k] = 1;
    linearization.ApplyJ(unit, column);
    unit[k] = 0;
    jacobian.col(k) = AsEigen(column);
  }
  MatrixXd damped = test::Gram(jacobian);
  damped.diagonal() += lambda * AsEigen(metric);
  return damped;
}

// Scales columns to a unit diagonal of the damped matrix, so that units cannot hide errors.
struct Scaled {
  VectorXd scale;
  explicit Scaled(const MatrixXd& damped) : scale(damped.diagonal().cwiseSqrt().cwiseInverse()) {}
};

struct Case {
  ReducedForm form;
  JacobianStorage storage;
  Isa isa;
};

std::vector<Case> Cases() {
  std::vector<Case> cases;
  for (const Isa isa : test::CpuIsas()) {
    for (const ReducedForm form : {ReducedForm::kImplicit, ReducedForm::kExplicit}) {
      for (const JacobianStorage storage : {JacobianStorage::kDouble, JacobianStorage::kFloat}) {
        cases.push_back({form, storage, isa});
      }
    }
  }
  return cases;
}

class BundleReducedSystem : public testing::TestWithParam<Case> {
 protected:
  BundleReducedSystem()
      : data_(SmallProblem()),
        problem_(data_, {.storage = GetParam().storage, .reduced_form = GetParam().form, .isa = GetParam().isa}),
        linearization_(LinearizeAt(problem_, Start(data_))),
        reduced_(linearization_->MakeReducedSystem()),
        metric_(problem_.num_parameters()) {
    linearization_->DiagJTJ(metric_);
    for (double& d : metric_) d = std::max(d, 1e-3);
  }
  // For one damping value. Called twice, since a rejected step changes the damping.
  void Check(double lambda) {
    const Index n = problem_.num_parameters(), kept = reduced_->size();
    ASSERT_EQ(kept, 81);
    reduced_->SetDamping(lambda, metric_);
    const MatrixXd damped = DenseDamped(*linearization_, lambda, metric_);
    const VectorXd scale = damped.diagonal().cwiseSqrt();
    const MatrixXd schur = test::SchurComplement(damped, kept);
    // Relative to the square roots of the diagonal entries of row and column.
    Cpu::Vector unit(kept), column(kept);
    for (Index k = 0; k < kept; ++k) {
      unit[k] = 1;
      reduced_->Apply(unit, column);
      unit[k] = 0;
      for (Index i = 0; i < kept; ++i) EXPECT_NEAR(column[i], schur(i, k), 1e-10 * scale[i] * scale[k]);
    }
    BlockDiagonal<Cpu> blocks(kept, reduced_->kept_groups());
    reduced_->DiagonalBlocks(blocks);
    ASSERT_EQ(blocks.groups().size(), 1u);
    for (Index i = 0; i < blocks.groups()[0].count; ++i) {
      for (int r = 0; r < 9; ++r) {
        for (int c = 0; c <= r; ++c) {
          const Index row = blocks.groups()[0].Parameter(i, r), col = blocks.groups()[0].Parameter(i, c);
          EXPECT_NEAR(blocks.values(0)[PackedLower(r, c) * 9 + i], schur(row, col), 1e-10 * scale[row] * scale[col]);
        }
      }
    }
    // If S is formed, the factor solves with S.
    LinearOperator<Cpu>* factor = reduced_->Factorize();
    ASSERT_EQ(factor != nullptr, GetParam().form == ReducedForm::kExplicit);
    EXPECT_EQ(reduced_->factor_description().find("sparse Cholesky of ") == 0, factor != nullptr);
    if (factor != nullptr) {
      ASSERT_EQ(factor->size(), kept);
      VectorXd given = VectorXd::LinSpaced(kept, -1, 2).cwiseProduct(scale.head(kept));
      Cpu::Vector solved(kept), b(kept);
      AsEigen(b) = given;
      factor->Apply(b, solved);
      const VectorXd back = test::Apply(schur, AsEigen(solved));
      EXPECT_LE((back - given).cwiseQuotient(scale.head(kept)).norm(),
                1e-9 * given.cwiseQuotient(scale.head(kept)).norm());
    }
    // Reducing, solving densely and back-substituting solves the whole system.
    Cpu backend;
    Cpu::Vector rhs(n), reduced_rhs(kept), step(n);
    FillRandom(backend, 6, rhs.view());
    for (Index k = 0; k < n; ++k) rhs[k] *= scale[k];
    reduced_->ReduceRhs(rhs, reduced_rhs);
    AsEigen(step).head(kept) = test::SolveSymmetric(schur, AsEigen(reduced_rhs));
    reduced_->BackSubstitute(rhs, step);
    const VectorXd residual = (test::Apply(damped, AsEigen(step)) - AsEigen(rhs)).cwiseQuotient(scale);
    EXPECT_LE(residual.norm(), 1e-10 * AsEigen(rhs).cwiseQuotient(scale).norm());
  }

  BundleData data_;
  BundleProblem problem_;
  std::unique_ptr<LinearizationAdaptor<Cpu>> linearization_;
  std::unique_ptr<ReducedSystem<Cpu>> reduced_;
  Cpu::Vector metric_;
};

TEST_P(BundleReducedSystem, IsTheSchurComplement) {
  Check(1e-2);
  Check(1);
}

INSTANTIATE_TEST_SUITE_P(All, BundleReducedSystem, testing::ValuesIn(Cases()),
                         [](const testing::TestParamInfo<Case>& param) {
                           const Case& c = param.param;
                           return std::string(c.form == ReducedForm::kExplicit ? "Explicit" : "Implicit") +
                                  (c.storage == JacobianStorage::kFloat ? "Float" : "Double") + "_" + IsaName(c.isa);
                         });

}  // namespace
}  // namespace vesta::bundle
