// SPDX-License-Identifier: Apache-2.0
// A problem spread over processes: each has its share of the parts, their data, Jacobians and work, and its shard of
// the vectors and the preconditioner of a conjugate gradient iteration; x, gradient and step are on all of them.
//
// All processes run the same solve: SolveLm with the same options from the same x. What the engine asks for is formed
// by the processes together (gradient, products with H, its diagonal and blocks, costs), summed by a fixed tree over
// the parts (kernels/ranks/sum_over_ranks.h). So the numbers are the same bits on each process, for any number of them
// and of threads, and so is every decision. Time limits and callbacks that stop do so on all (Collective).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kernels/ranks/sum_over_ranks.h"
#include "solver/distributed/part_map.h"
#include "solver/distributed/problem_parts.h"
#include "solver/distributed/shards.h"
#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

// A part that falls to this process.
template <Backend B>
struct OwnPart {
  explicit OwnPart(std::unique_ptr<Problem<B>> made) : owned(std::move(made)), problem(*owned) {}

  std::unique_ptr<Problem<B>> owned;
  ProblemAdaptor<B> problem;
  PartMap parameters, tangent;
  Index first_unit = 0;
  typename B::Vector x;  // its parameters, to evaluate at; room
};

// For host memory. Linear solvers that see H alone will do: PCG, and PCG with a group eliminated where the parts allow
// it (ProblemParts::eliminates); block Jacobi and Schur-Jacobi.
template <Backend B>
class DistributedProblem final : public Problem<B>,
                                 public OnManifold<B>,
                                 public InUnits<B>,
                                 public InBatches<B>,
                                 public WithBounds<B>,
                                 public WithDampingMetric<B>,
                                 public Collective,
                                 public WithNames,
                                 public Describes<B> {
 public:
  using Base = Problem<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;
  using S = typename B::Scalar;

  // Makes the parts of this process; called by all. ranks and parts must outlive it. Throws Error where there are more
  // processes than parts, and where parts do not fit the whole.
  DistributedProblem(Communicator& ranks, ProblemParts<B>& parts);

  Index num_parameters() const override { return parts_.num_parameters(); }
  Index num_tangent() const override { return parts_.num_tangent(); }
  // Those of the parts, one part after another.
  Index num_units() const override { return num_units_; }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override { return this->LinearizeOnlyBatch(x); }
  int num_batches() const override { return 1; }
  std::unique_ptr<Linearization<B>> LinearizeBatch(ConstVectorView x, int batch) override;
  void OnNewPoint(int turn) override;
  bool OnAnyProcess(bool mine) override { return OnAnyRank(ranks_, mine); }

  // Those of ProblemParts::geometry.
  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override {
    return geometry_.DampingMetric(x, diag_h, D);
  }
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override {
    geometry_.Plus(backend, x, delta, out);
  }
  bool has_bounds() const override { return geometry_.has_bounds(); }
  bool IsFeasible(ConstVectorView x) override { return geometry_.IsFeasible(x); }
  void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) override {
    geometry_.MaskActiveBounds(x, negative_gradient, mask);
  }
  void ClipStep(ConstVectorView x, VectorView step) override { geometry_.ClipStep(x, step); }
  std::string NameTangent(Index k) override { return geometry_.NameTangent(k); }
  std::string DescribeInfeasible(ConstVectorView x) override { return geometry_.DescribeInfeasible(x); }
  std::string DescribeDegenerate(ConstVectorView x) override { return geometry_.DescribeDegenerate(x); }
  // Of the first part that has something to say.
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override;

  Communicator& ranks() { return ranks_; }
  ProblemParts<B>& parts() { return parts_; }
  std::span<OwnPart<B>> own() { return own_; }
  TreeNode own_terms() const { return TermsOf(parts_.num_parts(), ranks_, ranks_.rank()); }
  OwnPart<B>& part(Index term) { return own_[static_cast<std::size_t>(term - own_terms().begin)]; }
  // Of vectors as long as a step.
  SumOverRanks<S>& tangent_sum() { return *tangent_sum_; }
  // Which process holds what in an iteration, and sums of which each process gets its shard alone. The first call is
  // made by all together.
  const Shards& shards();
  SumOverRanks<S>& shard_sum();
  // Of as many numbers as there are parts; `mine` are those of this process.
  double SumNumbers(const std::vector<double>& mine);
  // x as the part sees it, valid until the next call for this part.
  ConstVectorView Localize(ConstVectorView x, OwnPart<B>& part) const {
    return part.parameters.template Local<S>(x, part.x);
  }

 private:
  void CheckSameProblem();
  std::vector<Support> TangentSupports() const;
  // Once.
  void CheckSameStart(ConstVectorView x);

  Communicator& ranks_;
  ProblemParts<B>& parts_;
  ProblemAdaptor<B> geometry_;
  std::vector<OwnPart<B>> own_;
  std::unique_ptr<SumOverRanks<S>> tangent_sum_, shard_sum_;
  std::unique_ptr<Shards> shards_;
  Index num_units_ = 0;
  bool has_checked_start_ = false;
};

}  // namespace vesta
