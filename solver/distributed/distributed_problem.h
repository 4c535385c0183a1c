// SPDX-License-Identifier: Apache-2.0
// A problem distributed over processes. Each process has its share of the parts, with their data, Jacobians and work.
// It also has its shard of the PCG vectors and of the preconditioner. x, gradient and step are stored on every process.
//
// All processes run the same solve: SolveLm with the same options and the same x. They compute gradients, products with
// H, its diagonal and blocks, and costs together. The sums use a fixed tree over the parts
// (kernels/ranks/sum_over_ranks.h). Results are therefore bit-identical on all processes, for any number of processes
// and threads, and all processes make the same decisions. Time limits and callbacks stop all processes together
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
  PartMap parameters, tangent;
  Index first_unit = 0;
  typename B::Vector x;  // work memory: the part's parameters at the x of an evaluation
};

// For host memory. It supports the linear solvers that use H alone: PCG with block Jacobi, and PCG with an eliminated
// group and Schur-Jacobi. The second needs ProblemParts::eliminates.
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

  // Creates the parts of this process. Collective. ranks and parts must outlive this object. Throws Error if there are
  // more processes than parts, or if a part does not fit the whole problem.
  DistributedProblem(Communicator& ranks, ProblemParts<B>& parts);

  Index num_parameters() const override { return parts_.num_parameters(); }
  Index num_tangent() const override { return parts_.num_tangent(); }
  // Units of all parts, one part after another.
  Index num_units() const override { return num_units_; }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override { return this->LinearizeOnlyBatch(x); }
  int num_batches() const override { return 1; }
  std::unique_ptr<Linearization<B>> LinearizeBatch(ConstVectorView x, int batch) override;
  void OnNewPoint(int turn) override;
  bool OnAnyProcess(bool mine) override { return OnAnyRank(ranks_, mine); }

  // These functions use ProblemParts::geometry.
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
  // Description from the first part that has one.
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override;

  Communicator& ranks() { return ranks_; }
  ProblemParts<B>& parts() { return parts_; }
  std::span<OwnPart<B>> own() { return own_; }
  TreeNode own_terms() const { return TermsOf(parts_.num_parts(), ranks_, ranks_.rank()); }
  OwnPart<B>& part(Index term) { return own_[static_cast<std::size_t>(term - own_terms().begin)]; }
  // Sums vectors with the size of a step.
  SumOverRanks<S>& tangent_sum() { return *tangent_sum_; }
  // The shard of each process in a PCG iteration, and sums that return only this process's shard. The first call is
  // collective.
  const Shards& shards();
  SumOverRanks<S>& shard_sum();
  // Sums one number per part; `mine` holds the numbers of this process's parts. Collective.
  double SumNumbers(const std::vector<double>& mine);
  // Returns the part's entries of x. Valid until the next call for this part.
  ConstVectorView Localize(ConstVectorView x, OwnPart<B>& part) const {
    return part.parameters.template Local<S>(x, part.x);
  }

 private:
  void CheckSameProblem();
  std::vector<Support> TangentSupports() const;
  // Checks the start on the first call only.
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
