// SPDX-License-Identifier: Apache-2.0
// The damped normal equations of all batches at one x.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/normal_system.h"
#include "solver/lm_options.h"

namespace vesta {

// Solves the damped normal equations of all batches at one x, by the chosen BatchMode.
//
// kExact solves the sum. kMerge solves each batch alone and merges the steps per parameter: step = sum M_b step_b / sum
// M_b with M_b = diag(H_b) (3DGS-LM, eq. 7). Columns without weight do not move. The fixed point of kMerge is not the
// minimum of the full cost. It is close if every batch resembles the whole (every k-th image), and not if batches are
// consecutive images.
template <Backend B>
class BatchedSystem {
 public:
  // Linearizes all batches. x must outlive this object. scale is computed from the first linearization if it is empty.
  BatchedSystem(const LmOptions& options, B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                ColumnScale<B>& scale, LmSummary& summary);

  // Fault of the first system that has one.
  const SystemFault& fault() const { return fault_; }
  // DescribeZeroColumnGradient of the first system with such a gradient above the gradient tolerance and above
  // UnderflownGradient; otherwise empty.
  const std::string& zero_column_gradient() const { return zero_column_gradient_; }
  // -g, summed over all batches.
  typename B::ConstVectorView negative_gradient() const {
    return whole() ? whole()->negative_gradient() : negative_gradient_.view();
  }
  // A weight per column, of the scale of H: D, or the diagonal of H with merged batches.
  typename B::ConstVectorView weights() const { return whole() ? whole()->metric() : diagonal_.view(); }

  // Predicted(gamma) is the decrease of the cost for gamma * step, by the undamped model of all batches.
  struct Direction {
    PcgSummary pcg;  // last batch's summary; iterations summed over all batches
    double gradient_dot_step = 0;
    double curvature = 0;
    double Predicted(double gamma) const { return -gamma * gradient_dot_step - 0.5 * gamma * gamma * curvature; }
  };
  Direction Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);
  // Evaluates the model along another step. Costs one product per batch.
  void Measure(typename B::ConstVectorView step, Direction& direction);

 private:
  // The only system, or null if there are several.
  NormalSystem<B>* whole() const { return systems_.size() == 1 ? systems_.front().get() : nullptr; }
  std::unique_ptr<NormalSystem<B>> MakeSystem(int first, int count);
  // Returns the stored system of a batch. If it is not stored, creates it in `fresh`.
  NormalSystem<B>& System(std::size_t batch, std::unique_ptr<NormalSystem<B>>& fresh);
  Direction Merge(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);

  const LmOptions& options_;
  B& backend_;
  ProblemAdaptor<B> problem_;
  typename B::ConstVectorView x_;
  ColumnScale<B>& scale_;
  LmSummary& summary_;
  std::vector<std::unique_ptr<NormalSystem<B>>> systems_;  // null if created again at each use
  typename B::Vector negative_gradient_, diagonal_;        // sums over the systems; empty if there is one system
  SystemFault fault_;
  std::string zero_column_gradient_;
};

}  // namespace vesta
