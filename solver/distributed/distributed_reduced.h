// SPDX-License-Identifier: Apache-2.0
// A distributed problem with a group eliminated: each process eliminates the parameters of its parts, and only vectors
// of the kept ones go between processes.
//
// With parts p that share the kept parameters alone, H + lambda D = [B E; E^T C], B = sum B_p, and E, C of part p stand
// in rows and columns of its own. So S = lambda D_kept + sum_p (B_p - E_p C_p^-1 E_p^T).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/distributed/distributed_problem.h"
#include "solver/reduced_system.h"

namespace vesta {

template <Backend B>
class DistributedLinearization;

template <Backend B>
class DistributedReducedSystem final : public ReducedSystem<B> {
 public:
  using Base = ReducedSystem<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;
  using S = typename B::Scalar;

  // Borrows the linearization. Throws Error where the parts do not eliminate as ProblemParts::eliminates says.
  explicit DistributedReducedSystem(DistributedLinearization<B>& linearization);

  Index size() const override { return kept_; }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  std::vector<BlockGroup> kept_groups() const override { return systems_.front()->kept_groups(); }
  void DiagonalBlocks(BlockDiagonal<B>& blocks) override;

 private:
  // The part's entries of a vector, those that are kept set to zero.
  ConstVectorView LocalizeEliminated(ConstVectorView v, const PartMap& map);

  DistributedLinearization<B>& linearization_;
  DistributedProblem<B>& problem_;
  std::vector<std::unique_ptr<ReducedSystem<B>>> systems_;  // of this process's parts
  Index kept_ = 0;
  double lambda_ = 0;
  ConstVectorView metric_;
  std::unique_ptr<SumOverRanks<S>> kept_sum_;
  typename B::Vector local_, local_step_;
};

}  // namespace vesta
