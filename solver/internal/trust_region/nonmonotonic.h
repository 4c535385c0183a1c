// SPDX-License-Identifier: Apache-2.0
// Nonmonotonic steps: a step may raise the cost, if the cost has decreased enough since an earlier point, the
// reference. Conn, Gould, Toint, Trust-region methods, 2000, algorithm 10.1.2. Such steps follow a curved valley
// without staying at its bottom.
#pragma once

#include <algorithm>

namespace vesta {

class NonmonotonicReference {
 public:
  // max_steps: after this number of successive accepted steps without a new lowest cost, the reference is replaced. The
  // new reference is the point with the highest cost since the lowest cost. 0: the gain ratio alone decides.
  explicit NonmonotonicReference(int max_steps) : max_steps_(max_steps) {}
  bool enabled() const { return max_steps_ > 0; }
  // cost: the cost at the start.
  void Start(double cost) { lowest_ = reference_.cost = candidate_.cost = cost; }
  double lowest() const { return lowest_; }

  // The larger of two gain ratios: rho is the one of the trial point, the other is since the reference. cost: of the
  // trial point; predicted: its predicted decrease, > 0.
  double GainRatio(double rho, double cost, double predicted) const {
    return enabled() ? std::max(rho, (reference_.cost - cost) / (reference_.predicted + predicted)) : rho;
  }
  // Updates the reference after an accepted step. Returns true if the new cost is the lowest so far.
  bool OnAccept(double cost, double predicted) {
    reference_.predicted += predicted;
    candidate_.predicted += predicted;
    if (cost < lowest_) {
      lowest_ = cost;
      candidate_ = {cost};
      steps_ = 0;
      return true;
    }
    if (cost > candidate_.cost) candidate_ = {cost};
    if (++steps_ == max_steps_) reference_ = candidate_;
    return false;
  }

  // Saves or loads the state, without max_steps.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(reference_.cost, reference_.predicted, candidate_.cost, candidate_.predicted, lowest_, steps_);
  }

 private:
  // The cost of a point, and the sum of the predicted decreases of all accepted steps since that point.
  struct Point {
    double cost = 0, predicted = 0;
  };
  int max_steps_;
  Point reference_, candidate_;
  double lowest_ = 0;
  int steps_ = 0;  // accepted steps since the lowest cost
};

}  // namespace vesta
