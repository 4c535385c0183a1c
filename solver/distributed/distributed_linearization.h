// SPDX-License-Identifier: Apache-2.0
// A distributed problem at one x: the linearizations of this process's parts, and their sums over all processes.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solver/distributed/distributed_problem.h"

namespace vesta {

template <Backend B>
class DistributedLinearization final : public Linearization<B>,
                                       public WithLossWeights<B>,
                                       public WithProductH<B>,
                                       public WithBlocks<B>,
                                       public WithReducedSystem<B>,
                                       public WithShardedSystem<B>,
                                       public WithOwnDescent<B> {
 public:
  using Base = Linearization<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;
  using S = typename B::Scalar;

  DistributedLinearization(DistributedProblem<B>& problem, ConstVectorView x);

  // Of all parts, wherever they are.
  Index num_residuals() const override { return num_residuals_; }
  Index num_parameters() const override { return problem_.num_tangent(); }
  // No process has all residuals: these throw Error.
  ConstVectorView residuals() const override;
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  // weighted(), so that no solver asks for them.
  void ApplyW(ConstVectorView u, VectorView Wu) override;

  void Gradient(VectorView g) override;
  bool has_own_descent() const override { return has_own_descent_; }
  void Descent(VectorView d) override;
  void DiagJTJ(VectorView d) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  double Curvature(ConstVectorView v) override;
  std::vector<BlockGroup> block_groups() const override { return problem_.parts().block_groups(); }
  void BlockGram(BlockDiagonal<B>& blocks) override;
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() override;
  std::unique_ptr<ShardedSystem<B>> MakeShardedSystem() override;
  // Of H v and of the blocks, what lies in this process's shard.
  void ApplyHToShard(ConstVectorView v, VectorView shard);
  void ShardOfBlocks(BlockDiagonal<B>& blocks);

  DistributedProblem<B>& problem() { return problem_; }
  LinearizationAdaptor<B>& of(Index term) {
    return *linearizations_[static_cast<std::size_t>(term - problem_.own_terms().begin)];
  }

 private:
  // out = the sum over all parts of what give(linearization, part, to) writes, all of the part's own entries.
  template <class Give>
  void SumParts(const Give& give, VectorView out);
  // What writes a term of it, for SumOverRanks.
  template <class Give>
  auto Term(const Give& give);
  // What gives a part's product with v.
  auto ProductWith(ConstVectorView v) {
    return [this, v](LinearizationAdaptor<B>& linearization, const OwnPart<B>& part, VectorView to) {
      linearization.ApplyH(part.tangent.template Local<S>(v, local_in_), to);
    };
  }
  void SumGradients();
  // finished: as SumOverRanks has it. The sum's values: all, or those of this process's shard.
  void SumBlocks(std::vector<Support> finished, VectorView values);

  DistributedProblem<B>& problem_;
  std::vector<typename B::Vector> x_;  // of parts that do not see all of x
  std::vector<std::unique_ptr<LinearizationAdaptor<B>>> linearizations_;
  Index num_residuals_ = 0;
  bool has_own_descent_ = false;
  typename B::Vector gradient_, squares_;  // until someone asks for them; the second: of the units' gradients
  // In this process's shard, between the diagonal and the blocks, where they come from one pass.
  std::optional<BlockDiagonal<B>> blocks_;
  typename B::Vector local_in_, local_out_;
};

}  // namespace vesta
