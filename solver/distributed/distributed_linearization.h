// SPDX-License-Identifier: Apache-2.0
// A distributed problem linearized at one x. It stores the linearizations of this process's parts, and sums results
// over all processes. For PCG it creates a ShardedSystem or a ReducedSystem (solver/reduced_system.h).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/distributed/distributed_problem.h"
#include "solver/reduced_system.h"

namespace vesta {

// All functions that sum over processes are collective.
template <Backend B>
class DistributedLinearization final : public Linearization<B>,
                                       public WithLossWeights<B>,
                                       public WithProductH<B>,
                                       public WithBlocks<B>,
                                       public WithReducedSystem<B>,
                                       public WithShardedSystem<B>,
                                       public WithOwnRightHandSide<B> {
 public:
  using Base = Linearization<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;
  using S = typename B::Scalar;

  DistributedLinearization(DistributedProblem<B>& problem, ConstVectorView x);

  // Summed over all parts of all processes.
  Index num_residuals() const override { return num_residuals_; }
  Index num_parameters() const override { return problem_.num_tangent(); }
  // No process has all residuals, so these throw Error.
  ConstVectorView residuals() const override;
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  // weighted() is true, so no solver calls this.
  void ApplyW(ConstVectorView u, VectorView Wu) override;

  void Gradient(VectorView g) override;
  bool has_own_right_hand_side() const override { return has_own_right_hand_side_; }
  void RightHandSide(VectorView d) override;
  void DiagJTJ(VectorView d) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  double Curvature(ConstVectorView v) override;
  std::vector<BlockGroup> block_groups() const override { return problem_.parts().block_groups(); }
  void BlockGram(BlockDiagonal<B>& blocks) override;
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() override;
  std::unique_ptr<ShardedSystem<B>> MakeShardedSystem() override;
  // Compute only this process's shard of H v, or of the diagonal blocks of H.
  void ApplyHToShard(ConstVectorView v, VectorView shard);
  void ShardOfBlocks(BlockDiagonal<B>& blocks);

  DistributedProblem<B>& problem() { return problem_; }
  // The linearization of part `term` of this process.
  LinearizationAdaptor<B>& of(Index term) {
    return *linearizations_[static_cast<std::size_t>(term - problem_.own_terms().begin)];
  }

 private:
  // out = the sum of one vector per part. give(linearization, part, to) writes all entries of this vector to `to`.
  template <class Give>
  void SumParts(const Give& give, VectorView out);
  // The function that writes one term of this sum, for SumOverRanks.
  template <class Give>
  auto Term(const Give& give);
  // The function that computes a part's term of H v.
  auto ProductWith(ConstVectorView v) {
    return [this, v](LinearizationAdaptor<B>& linearization, const OwnPart<B>& part, VectorView to) {
      linearization.ApplyH(part.tangent.template Local<S>(v, local_in_), to);
    };
  }
  // Sums gradients. Also sums squared gradients if the parts have their own right-hand side.
  void SumGradients();
  // Sums the diagonal blocks of H. finished: the values of each process's shard, as in SumOverRanks; values: this
  // process's shard, or all values if `finished` is empty.
  void SumBlocks(std::vector<Support> finished, VectorView values);

  DistributedProblem<B>& problem_;
  std::vector<typename B::Vector> x_;  // per part: its entries of x; empty if the part has all of x
  std::vector<std::unique_ptr<LinearizationAdaptor<B>>> linearizations_;
  Index num_residuals_ = 0;
  bool has_own_right_hand_side_ = false;
  // The gradient, and the sum of the units' squared gradients, until Gradient or RightHandSide returns them.
  typename B::Vector gradient_, squares_;
  // This process's shard of the diagonal blocks of H. If one pass computes diagonal and blocks, DiagJTJ stores the
  // blocks here until ShardOfBlocks.
  std::optional<BlockDiagonal<B>> blocks_;
  typename B::Vector local_in_, local_out_;
};

// The Schur complement of a distributed problem. Each process eliminates parameters of its own parts. Processes
// exchange only vectors of the kept parameters.
//
// Parts p share only kept parameters. In H + lambda D = [B E; E^T C], with the kept parameters first, B is lambda
// D_kept plus the sum of the parts' blocks B_p. Each part has its own columns E_p of E and diagonal block C_p of C. So
// the Schur complement is S = lambda D_kept + sum_p (B_p - E_p C_p^-1 E_p^T).
template <Backend B>
class DistributedReducedSystem final : public ReducedSystem<B> {
 public:
  using Base = ReducedSystem<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;
  using S = typename B::Scalar;

  // The linearization must outlive this object. Throws Error if the parts violate ProblemParts::eliminates.
  explicit DistributedReducedSystem(DistributedLinearization<B>& linearization);

  Index size() const override { return kept_; }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  std::vector<BlockGroup> kept_groups() const override { return systems_.front()->kept_groups(); }
  void DiagonalBlocks(BlockDiagonal<B>& blocks) override;

 private:
  // The part's entries of v, with kept parameters set to zero.
  ConstVectorView LocalizeEliminated(ConstVectorView v, const PartMap& map);

  DistributedLinearization<B>& linearization_;
  DistributedProblem<B>& problem_;
  std::vector<std::unique_ptr<ReducedSystem<B>>> systems_;  // one per part of this process
  Index kept_ = 0;
  double lambda_ = 0;
  ConstVectorView metric_;
  std::unique_ptr<SumOverRanks<S>> kept_sum_;
  typename B::Vector local_, local_step_;
};

// The sharded system of a distributed problem.
//
// For a product H p, an all-gather first gives each process the whole vector p. Each process then computes the terms of
// its parts, and receives the sum for its own shard of H p (reduce-scatter). Both together transfer as many bytes as
// one all-reduce.
template <Backend B>
class DistributedShards final : public ShardedSystem<B> {
 public:
  using typename ShardedSystem<B>::ConstVectorView;
  using typename ShardedSystem<B>::VectorView;
  using S = typename B::Scalar;

  // `linearization` must outlive this object. Collective.
  explicit DistributedShards(DistributedLinearization<B>& linearization)
      : linearization_(linearization), shards_(linearization.problem().shards()), products_(shards_) {}

  Index num_residuals() const override { return linearization_.num_residuals(); }
  Index num_parameters() const override { return shards_.own().size(); }
  void ApplyH(ConstVectorView v, VectorView Hv) override {
    linearization_.ApplyHToShard(shards_.is_whole() ? v : Gathered(v), Hv);
  }
  // Empty if the parts have no blocks.
  std::vector<BlockGroup> block_groups() const override {
    return linearization_.block_groups().empty() ? std::vector<BlockGroup>() : shards_.groups();
  }
  void BlockGram(BlockDiagonal<B>& blocks) override { linearization_.ShardOfBlocks(blocks); }

  ConstVectorView ShardOf(ConstVectorView whole, typename B::Vector& storage) const override {
    if (shards_.is_whole()) return whole;
    storage.ResizeForOverwrite(num_parameters());
    shards_.Take<S>(whole, storage.view());
    return storage.view();
  }
  void Gather(ConstVectorView shard, VectorView whole) override { shards_.Gather<S>(shard, whole, storage_); }
  const InnerProducts<B>& products() const override { return products_; }

 private:
  // The whole vector, valid until the next call. Collective.
  ConstVectorView Gathered(ConstVectorView shard) {
    whole_.ResizeForOverwrite(linearization_.num_parameters());
    Gather(shard, whole_.view());
    return whole_.view();
  }

  DistributedLinearization<B>& linearization_;
  const Shards& shards_;
  ShardProducts<S> products_;
  typename B::Vector whole_, storage_;
};

}  // namespace vesta
