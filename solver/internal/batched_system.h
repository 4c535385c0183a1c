// SPDX-License-Identifier: Apache-2.0
// The damped system of all batches at one x, solved exactly or batch by batch.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/normal_system.h"
#include "solver/lm_options.h"

namespace vesta {

// The damped normal equations of all batches at one x.
//
// kExact solves the sum. kMerge solves each batch alone and takes step = sum M_b step_b / sum M_b per parameter, with
// M_b = diag(H_b) (3DGS-LM, eq. 7); columns without weight do not move. Its fixed point is not the minimum of the whole
// cost: batches that each look like the whole (every k-th image) come close, consecutive ones do not.
template <Backend B>
class BatchedSystem {
 public:
  // Linearizes. x must outlive this object. scale: made from the first linearization when it is empty.
  BatchedSystem(const LmOptions& options, B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                ColumnScale<B>& scale, LmSummary& summary);

  // Of the first system that has one.
  const SystemFault& fault() const { return fault_; }
  // DescribeZeroColumnGradient of the first system that has one above the gradient tolerance and what underflow
  // explains.
  const std::string& zero_column_gradient() const { return zero_column_gradient_; }
  // -g of all batches.
  typename B::ConstVectorView negative_gradient() const {
    return whole() ? whole()->negative_gradient() : negative_gradient_.view();
  }
  // A weight of each column, of H's scale: D, or of merged batches the diagonal of H.
  typename B::ConstVectorView weights() const { return whole() ? whole()->metric() : diagonal_.view(); }

  // gamma step lowers the cost by Predicted(gamma) according to the undamped model of all batches.
  struct Direction {
    PcgSummary pcg;  // of the last batch; iterations summed
    double gradient_dot_step = 0;
    double curvature = 0;
    double Predicted(double gamma) const { return -gamma * gradient_dot_step - 0.5 * gamma * gamma * curvature; }
  };
  Direction Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);
  // The model along another step, at one product a batch.
  void Measure(typename B::ConstVectorView step, Direction& direction);

 private:
  // The one system, where there is no other.
  NormalSystem<B>* whole() const { return systems_.size() == 1 ? systems_.front().get() : nullptr; }
  std::unique_ptr<NormalSystem<B>> MakeSystem(int first, int count);
  // The system of one batch: the one held, or a new one in `fresh`.
  NormalSystem<B>& System(std::size_t batch, std::unique_ptr<NormalSystem<B>>& fresh);
  Direction Merge(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);

  const LmOptions& options_;
  B& backend_;
  ProblemAdaptor<B> problem_;
  typename B::ConstVectorView x_;
  ColumnScale<B>& scale_;
  LmSummary& summary_;
  std::vector<std::unique_ptr<NormalSystem<B>>> systems_;  // null where made anew at each use
  typename B::Vector negative_gradient_, diagonal_;        // sums over the systems; empty where there is one
  SystemFault fault_;
  std::string zero_column_gradient_;
};

}  // namespace vesta
