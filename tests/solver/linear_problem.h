// SPDX-License-Identifier: Apache-2.0
// Linear least squares 1/2 |A x - b|^2 with dense A, in batches of rows: all results are known exactly.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/problem_interfaces.h"
#include "tests/solver/dense_operator.h"

namespace vesta {

class LinearProblem final : public Problem<Cpu>, public InBatches<Cpu>, public WithDampingMetric<Cpu> {
 public:
  struct Batch {
    Eigen::MatrixXd a;
    Eigen::VectorXd b;
  };
  explicit LinearProblem(std::vector<Batch> batches) : batches_(std::move(batches)) {}

  Index num_parameters() const override { return batches_.front().a.cols(); }
  int num_batches() const override { return static_cast<int>(batches_.size()); }
  double Cost(Cpu::ConstVectorView x) override {
    double cost = 0;
    for (const Batch& batch : batches_) cost += 0.5 * (test::Apply(batch.a, AsEigen(x)) - batch.b).squaredNorm();
    return cost;
  }
  std::unique_ptr<Linearization<Cpu>> Linearize(Cpu::ConstVectorView x) override { return LinearizeOnlyBatch(x); }
  std::unique_ptr<Linearization<Cpu>> LinearizeBatch(Cpu::ConstVectorView x, int batch) override {
    ++linearizations;
    return std::make_unique<Rows>(batches_[static_cast<std::size_t>(batch)], x, groups, own_right_hand_side);
  }
  bool DampingMetric(Cpu::ConstVectorView, Cpu::ConstVectorView diag_h, Cpu::VectorView metric) override {
    if (own_metric <= 0) return false;
    Cpu().Fill(own_metric, metric);
    last_diag_h = AsEigen(diag_h);
    return true;
  }

  std::vector<BlockGroup> groups;
  double own_metric = 0;
  Eigen::VectorXd own_right_hand_side;  // factor of -g for each entry; empty: none
  Eigen::VectorXd last_diag_h;
  int linearizations = 0;

 private:
  class Rows final : public Linearization<Cpu>, public WithBlocks<Cpu>, public WithOwnRightHandSide<Cpu> {
   public:
    Rows(const Batch& batch, Cpu::ConstVectorView x, std::vector<BlockGroup> groups,
         Eigen::VectorXd own_right_hand_side)
        : a_(batch.a),
          groups_(std::move(groups)),
          own_right_hand_side_(std::move(own_right_hand_side)),
          residuals_(batch.b.size()) {
      AsEigen(residuals_.view()) = test::Apply(a_, AsEigen(x)) - batch.b;
    }
    Index num_residuals() const override { return a_.rows(); }
    Index num_parameters() const override { return a_.cols(); }
    Cpu::ConstVectorView residuals() const override { return residuals_.view(); }
    void ApplyJ(Cpu::ConstVectorView v, Cpu::VectorView u) override { AsEigen(u) = test::Apply(a_, AsEigen(v)); }
    void ApplyJT(Cpu::ConstVectorView u, Cpu::VectorView g) override {
      AsEigen(g) = test::ApplyTransposed(a_, AsEigen(u));
    }
    bool has_own_right_hand_side() const override { return own_right_hand_side_.size() > 0; }
    void RightHandSide(Cpu::VectorView d) override {
      ApplyJT(residuals_, d);
      AsEigen(d).array() *= -own_right_hand_side_.array();
    }
    void DiagJTJ(Cpu::VectorView d) override { AsEigen(d) = a_.colwise().squaredNorm().transpose(); }
    std::vector<BlockGroup> block_groups() const override { return groups_; }
    void BlockGram(BlockDiagonal<Cpu>& blocks) override {
      const Eigen::MatrixXd h = test::Gram(a_);
      for (std::size_t g = 0; g < groups_.size(); ++g) {
        const BlockGroup& group = groups_[g];
        for (Index i = 0; i < group.count; ++i) {
          for (int r = 0; r < group.size; ++r) {
            for (int c = 0; c <= r; ++c) {
              blocks.values(static_cast<int>(g))[PackedLower(r, c) * group.count + i] =
                  h(group.Parameter(i, r), group.Parameter(i, c));
            }
          }
        }
      }
    }

   private:
    const Eigen::MatrixXd& a_;
    std::vector<BlockGroup> groups_;
    Eigen::VectorXd own_right_hand_side_;
    Cpu::Vector residuals_;
  };

  std::vector<Batch> batches_;
};

// Random rows; the columns have very different scales.
inline LinearProblem::Batch RandomBatch(int rows, int cols, unsigned seed) {
  srand(seed);
  Eigen::MatrixXd a = Eigen::MatrixXd::Random(rows, cols);
  for (int c = 0; c < cols; ++c) a.col(c) *= std::pow(10.0, c - cols / 2);
  return {a, Eigen::VectorXd::Random(rows)};
}

}  // namespace vesta
