// A damped system with a block-diagonal group of parameters eliminated: the Schur complement, as an operator.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "solver/internal/linear/linear_operator.h"

namespace vesta {

// With the tangent space in two parts, kept (the first size() entries) and eliminated (the rest), and
//   H + lambda D = [B E; E^T C],  C block diagonal,
// this is y = S x with S = B - E C^-1 E^T over the kept parameters. A linearization that knows such a group offers
// one by WithReducedSystem; it borrows the linearization. SetDamping comes before everything else.
template <Backend B>
class ReducedSystem : public LinearOperator<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Number of kept parameters.
  Index size() const override = 0;
  // Sets lambda D (metric D: one entry a tangent parameter, eliminated ones included) and factorises C. D must stay
  // until the next call; of a part of a problem (solver/distributed), whose kept parameters are damped where all parts
  // are summed, it is there for the call alone. A block of C
  // that is singular in working precision is treated as BlockDiagonal::Factorize treats it.
  virtual void SetDamping(double lambda, ConstVectorView metric) = 0;
  // reduced = b_kept - E C^-1 b_eliminated. rhs: all tangent parameters; reduced: size() entries.
  virtual void ReduceRhs(ConstVectorView rhs, VectorView reduced) = 0;
  // Completes step (all tangent parameters), whose first size() entries solve the reduced system:
  // step_eliminated = C^-1 (b_eliminated - E^T step_kept).
  virtual void BackSubstitute(ConstVectorView rhs, VectorView step) = 0;

  // Blocks of the kept parameters for the Schur-Jacobi preconditioner; they cover 0..size()-1.
  virtual std::vector<BlockGroup> kept_groups() const = 0;
  // The diagonal blocks of S, damping included, into a matrix made from kept_groups(). Overwrites.
  virtual void DiagonalBlocks(BlockDiagonal<B>& diagonal) = 0;
  // An operator near S^-1 for the present damping, better than the inverse of those blocks and valid until the next
  // SetDamping. Null: there is none that pays.
  virtual LinearOperator<B>* Factorize() { return nullptr; }
  // What Factorize gives, for reports; empty: nothing.
  virtual std::string factor_description() const { return ""; }
};

}  // namespace vesta
