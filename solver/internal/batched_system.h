// SPDX-License-Identifier: Apache-2.0
// Computes the step of an iteration from the damped normal equations of all batches at one x.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/normal_system.h"
#include "solver/lm_options.h"

namespace vesta {

// Solves the damped normal equations (H + lambda D) step = -g, by the chosen BatchMode (solver/lm_options.h).
//
// kExact solves the sum of the equations of all batches. kMerge solves the equations of each batch b separately, and
// averages the steps per parameter: step = (sum_b M_b step_b) / (sum_b M_b) with M_b = diag(H_b) (3DGS-LM, eq. 7).
// Where the sum of M_b is 0, the step is 0. kMerge does not converge to the minimum of the full cost. It converges
// close to the minimum if every batch resembles the whole problem (every k-th image), but not if batches are
// consecutive images.
template <Backend B>
class BatchedSystem {
 public:
  // Linearizes all batches. options, x, scale and summary must outlive this object. cost is the variable cost at x
  // (WithFixedCost). If scale is empty, it is computed from this linearization. The summary's counts are updated.
  BatchedSystem(const LmOptions& options, B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                double cost, ColumnScale<B>& scale, LmSummary& summary);

  // The first fault in the systems of all batches. If there is one, Solve must not be called.
  const SystemFault& fault() const { return fault_; }
  // DescribeZeroColumnGradient of the first system with a nonzero gradient in a zero column; otherwise empty. Gradients
  // below the gradient tolerance, or below UnderflowGradient, count as zero.
  const std::string& zero_column_gradient() const { return zero_column_gradient_; }
  // -g, summed over all batches.
  typename B::ConstVectorView negative_gradient() const {
    return whole() ? whole()->negative_gradient() : negative_gradient_.view();
  }
  // A positive weight per column, of the magnitude of diag(H): D or, with merged batches, diag(H).
  typename B::ConstVectorView weights() const { return whole() ? whole()->metric() : diagonal_.view(); }

  // The quadratic model of the cost along a step, without damping, summed over all batches. Predicted(gamma) is the
  // predicted decrease of the cost for gamma * step.
  struct Direction {
    PcgSummary pcg;                // last batch's summary; iterations summed over all batches
    double gradient_dot_step = 0;  // g^T step
    double curvature = 0;          // step^T H step
    double Predicted(double gamma) const { return -gamma * gradient_dot_step - 0.5 * gamma * gamma * curvature; }
  };
  // Overwrites step.
  Direction Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);
  // Sets gradient_dot_step and curvature of `direction` for another step. Costs one product with H per batch.
  void Measure(typename B::ConstVectorView step, Direction& direction);

 private:
  // The only system, or null if there are several.
  NormalSystem<B>* whole() const { return systems_.size() == 1 ? systems_.front().get() : nullptr; }
  // Linearizes the batches first .. first + count - 1.
  std::unique_ptr<NormalSystem<B>> MakeSystem(int first, int count);
  // The column scales, from the diagonal of H at the start. Does not search for columns of rounding errors if the
  // batches are solved one by one.
  ColumnScale<B> MakeScale(typename B::ConstVectorView diagonal);
  // Returns the system of a batch. If it is not stored, creates it in `fresh`, which replaces the previous content.
  NormalSystem<B>& System(std::size_t batch, std::unique_ptr<NormalSystem<B>>& fresh);
  // Prepares a system, and sets the linear solver of the summary if it is empty.
  void Prepare(NormalSystem<B>& system, bool keep_diagonal);
  // Solve for kMerge.
  Direction Merge(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);

  const LmOptions& options_;
  B& backend_;
  ProblemAdaptor<B> problem_;
  typename B::ConstVectorView x_;
  ColumnScale<B>& scale_;
  LmSummary& summary_;
  std::vector<std::unique_ptr<NormalSystem<B>>> systems_;  // null pointers if hold_batches is false
  typename B::Vector negative_gradient_, diagonal_;        // sums over the systems; empty if there is one system
  SystemFault fault_;
  std::string zero_column_gradient_;
};

}  // namespace vesta
