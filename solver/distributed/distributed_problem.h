// SPDX-License-Identifier: Apache-2.0
// A problem that is a sum of parts (problem_parts.h), distributed over processes. Each process stores some of the
// parts, with their data and Jacobians, and evaluates them. It also stores its shard (its entries) of the PCG vectors
// and of the preconditioner. x, gradient and step are on every process.
//
// All processes call SolveLm with the same options and x. The cost, the gradient, the diagonal and blocks of the
// Gauss-Newton matrix H, and products with H are sums over the parts of all processes. Terms are added along a fixed
// tree (kernels/ranks/sum_over_ranks.h). Results are therefore bit-identical on all processes, and for any number of
// processes and threads. So all processes make the same decisions. Time limits and callbacks stop them together
// (Collective).
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

// A part that this process owns.
template <Backend B>
struct OwnPart {
  explicit OwnPart(std::unique_ptr<Problem<B>> made) : owned(std::move(made)), problem(*owned) {}

  std::unique_ptr<Problem<B>> owned;
  ProblemAdaptor<B> problem;
  PartMap parameters, tangent;  // positions of the part's parameters in x and of its step entries in a step
  Index first_unit = 0;         // index of the part's first unit in the whole problem
  typename B::Vector x;         // scratch memory: the part's entries of x
};

// For host memory, and for two linear solvers that use only H. The first is PCG with block Jacobi. The second is PCG on
// the Schur complement with Schur-Jacobi (kReducedPcg); it needs ProblemParts::eliminates.
template <Backend B>
class DistributedProblem final : public Problem<B>,
                                 public OnManifold<B>,
                                 public WithFixedCost<B>,
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

  // Creates the parts of this process. Collective. ranks and parts must outlive this object. Throws Error if there are
  // more processes than parts, if problems of processes differ in size, or if the segments or batches of a part are
  // wrong.
  DistributedProblem(Communicator& ranks, ProblemParts<B>& parts);

  Index num_parameters() const override { return parts_.num_parameters(); }
  Index num_tangent() const override { return parts_.num_tangent(); }
  // The units of the first part, then of the second, and so on.
  Index num_units() const override { return num_units_; }
  double Cost(ConstVectorView x) override;
  double FixedCost(ConstVectorView x) override;
  double VariableCost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override { return this->LinearizeOnlyBatch(x); }
  int num_batches() const override { return 1; }
  std::unique_ptr<Linearization<B>> LinearizeBatch(ConstVectorView x, int batch) override;
  void OnNewPoint(int turn) override;
  bool OnAnyProcess(bool mine) override { return OnAnyRank(ranks_, mine); }

  // These functions call the object of ProblemParts::geometry.
  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override {
    return geometry_.DampingMetric(x, diag_h, D);
  }
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override {
    geometry_.Plus(backend, x, delta, out);
  }
  double VariableNorm(ConstVectorView x) override;
  double VariableMaxChange(ConstVectorView x, VectorView y) override;
  bool has_bounds() const override { return geometry_.has_bounds(); }
  bool IsFeasible(ConstVectorView x) override { return geometry_.IsFeasible(x); }
  void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) override {
    geometry_.MaskActiveBounds(x, negative_gradient, mask);
  }
  void ClipStep(ConstVectorView x, VectorView step) override { geometry_.ClipStep(x, step); }
  std::string NameTangent(Index k) override { return geometry_.NameTangent(k); }
  std::string DescribeInfeasible(ConstVectorView x) override { return geometry_.DescribeInfeasible(x); }
  std::string DescribeDegenerate(ConstVectorView x) override { return geometry_.DescribeDegenerate(x); }
  // The first description that is not empty, in the order of the parts.
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override;

  Communicator& ranks() { return ranks_; }
  ProblemParts<B>& parts() { return parts_; }
  // The parts of this process.
  std::span<OwnPart<B>> own() { return own_; }
  // Indices of this process's parts among all parts. Part k is term k of each sum.
  TreeNode own_terms() const { return TermsOf(parts_.num_parts(), ranks_, ranks_.rank()); }
  OwnPart<B>& part(Index term) { return own_[static_cast<std::size_t>(term - own_terms().begin)]; }
  // Sums vectors of num_tangent() entries over all parts.
  SumOverRanks<S>& tangent_sum() { return *tangent_sum_; }
  // shards: the entries of PCG vectors that each process stores. shard_sum: sums that return this process's shard. The
  // first call of each is collective.
  const Shards& shards();
  SumOverRanks<S>& shard_sum();
  // Sums one number per part. mine: the numbers of this process's parts. Collective.
  double SumNumbers(const std::vector<double>& mine);
  // The part's entries of x, valid until the next call for this part.
  ConstVectorView Localize(ConstVectorView x, OwnPart<B>& part) const {
    return part.parameters.template Local<S>(x, part.x);
  }

 private:
  // Throws Error if the problems of the processes differ in size.
  void CheckSameProblem();
  // The first call throws Error if the processes have different start values x. Later calls do nothing.
  void CheckSameStart(ConstVectorView x);
  // Sums cost_of(problem of the part, its entries of x) over all parts. Collective.
  template <class CostOf>
  double SumCosts(ConstVectorView x, const CostOf& cost_of);
  // The step entries of each part of this process.
  std::vector<Support> TangentSupports() const;

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
