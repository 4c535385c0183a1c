// SPDX-License-Identifier: Apache-2.0
// The damped system after elimination of the instruments' gains and offsets.
#pragma once

#include "readings.h"

// J^T J + lambda D = [B E; E^T C] with E = J_s^T J_o. C is block-diagonal, with a 2 x 2 block per instrument, because
// no reading depends on two instruments. Subscripts s and o mean the entries of the signal, and of the gains and
// offsets.
class WithoutInstruments final : public vesta::ReducedSystem<Backend> {
 public:
  explicit WithoutInstruments(ReadingsLinearization& at)
      : at_(at),
        signal_(at.setup().times()),
        own_(at.setup().own()),
        damped_(at.num_parameters(), at.block_groups()),
        C_(own_, {at.setup().OwnGroup(0)}),
        w_(own_),
        u_(at.num_residuals()) {}
  Index size() const override { return signal_; }

  void SetDamping(double lambda, ConstVectorView metric) override {
    lambda_ = lambda, metric_ = metric;
    backend_.Fill(0, damped_.all_values());
    at_.BlockGram(damped_);
    damped_.AddToDiagonal(lambda, metric);
    backend_.Copy(damped_.values(1), C_.values(0));
    C_.Factorize();
  }
  // reduced = b_s - J_s^T J_o C^-1 b_o, where b is rhs.
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override {
    C_.Solve(rhs.subspan(signal_, own_), w_);
    backend_.Fill(0, u_);
    at_.AddOwnJ(1, w_, u_);
    at_.ApplySignalJT(u_, reduced);
    backend_.Axpby(1, rhs.subspan(0, signal_), -1, reduced);
  }
  // y = J_s^T (I - J_o C^-1 J_o^T) J_s x + lambda D x. The factor in parentheses removes the part of the readings that
  // gains and offsets can explain.
  void Apply(ConstVectorView x, VectorView y) override {
    at_.ApplySignalJ(x, u_);
    at_.ApplyOwnJT(u_, w_);
    C_.Solve(w_, w_);
    at_.AddOwnJ(-1, w_, u_);
    at_.ApplySignalJT(u_, y);
    backend_.AddScaled(lambda_, metric_.subspan(0, signal_), x, y);
  }
  // step_o = C^-1 (b_o - J_o^T J_s step_s), where b is rhs.
  void BackSubstitute(ConstVectorView rhs, VectorView step) override {
    at_.ApplySignalJ(step.subspan(0, signal_), u_);
    at_.ApplyOwnJT(u_, w_);
    backend_.Axpby(1, rhs.subspan(signal_, own_), -1, w_);
    C_.Solve(w_, step.subspan(signal_, own_));
  }

  // For the preconditioner. Returns the diagonal of B, which is close to the diagonal of the Schur complement S. The
  // reason: one value of the signal changes few readings of an instrument, and gain and offset can explain very little
  // of this change.
  std::vector<vesta::BlockGroup> kept_groups() const override { return {at_.block_groups().front()}; }
  void DiagonalBlocks(Blocks& diagonal) override { backend_.Copy(damped_.values(0), diagonal.values(0)); }

 private:
  Backend backend_;
  ReadingsLinearization& at_;
  Index signal_, own_;  // numbers of kept and eliminated unknowns
  double lambda_ = 0;
  ConstVectorView metric_;
  Blocks damped_;  // diagonal blocks of the whole damped system
  Blocks C_;       // the last group of damped_, factorised
  Backend::Vector w_, u_;
};

inline std::unique_ptr<vesta::ReducedSystem<Backend>> ReadingsLinearization::MakeReducedSystem() {
  return std::make_unique<WithoutInstruments>(*this);
}
