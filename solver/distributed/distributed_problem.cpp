// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/distributed_problem.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "kernels/core/check.h"
#include "solver/distributed/distributed_linearization.h"

namespace vesta {

template <Backend B>
DistributedProblem<B>::DistributedProblem(Communicator& ranks, ProblemParts<B>& parts)
    : ranks_(ranks), parts_(parts), geometry_(parts.geometry()) {
  const int count = parts.num_parts();
  CheckTerms(count, ranks);
  CheckSameProblem();
  std::vector<Index> units;
  for (Index term = own_terms().begin; term < own_terms().end; ++term) {
    ProblemPart<B> made = parts.Make(static_cast<int>(term));
    if (!made.problem) Fail(kBadArgument, "ProblemParts::Make returned no problem for part {} of {}", term, count);
    OwnPart<B> part(std::move(made.problem));
    if (part.problem.num_batches() != 1) {
      Fail(kBadArgument, "part {} has {} batches; give each part one batch, and use more parts", term,
           part.problem.num_batches());
    }
    part.parameters = PartMap(made.parameters, part.problem.num_parameters(), parts.num_parameters(), "parameters");
    part.tangent = PartMap(made.tangent, part.problem.num_tangent(), parts.num_tangent(), "entries of a step");
    units.push_back(part.problem.num_units());
    own_.push_back(std::move(part));
  }
  tangent_sum_ = std::make_unique<SumOverRanks<S>>(ranks, count, parts.num_tangent(), TangentSupports());
  units = GatherValues(ranks, units);
  for (Index term = 0; term < count; ++term) {
    if (term >= own_terms().begin && term < own_terms().end) part(term).first_unit = num_units_;
    num_units_ += units[static_cast<std::size_t>(term)];
  }
}

template <Backend B>
std::vector<Support> DistributedProblem<B>::TangentSupports() const {
  std::vector<Support> supports;
  supports.reserve(own_.size());
  for (const OwnPart<B>& part : own_) supports.push_back(part.tangent.support());
  return supports;
}

template <Backend B>
const Shards& DistributedProblem<B>::shards() {
  if (!shards_) {
    constexpr int kPieces = 64;  // independent of the number of processes, at most the number of parts
    std::vector<BlockGroup> groups = parts_.block_groups();
    if (groups.empty()) groups.push_back({.size = 1, .count = num_tangent()});
    shards_ = std::make_unique<Shards>(ranks_, num_tangent(), groups, std::max(kPieces, parts_.num_parts()));
  }
  return *shards_;
}

template <Backend B>
SumOverRanks<typename B::Scalar>& DistributedProblem<B>::shard_sum() {
  if (!shard_sum_) {
    shard_sum_ = std::make_unique<SumOverRanks<S>>(ranks_, parts_.num_parts(), num_tangent(), TangentSupports(),
                                                   shards().of_ranks());
  }
  return *shard_sum_;
}

template <Backend B>
void DistributedProblem<B>::CheckSameProblem() {
  const std::vector<Index> sizes{parts_.num_parts(), parts_.num_parameters(), parts_.num_tangent()};
  const std::vector<Index> all = GatherValues(ranks_, sizes);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all[k] == all[k % sizes.size()]) continue;
    const std::size_t rank = k / sizes.size();
    Fail(
        kBadArgument,
        "process {} has a problem of {} parameters in {} parts, process 0 one of {} in {}: give all processes the same "
        "problem",
        rank, all[3 * rank + 1], all[3 * rank], all[1], all[0]);
  }
}

template <Backend B>
double DistributedProblem<B>::SumNumbers(const std::vector<double>& mine) {
  std::vector<double> all(static_cast<std::size_t>(parts_.num_parts()));
  std::vector<std::size_t> counts;
  counts.reserve(static_cast<std::size_t>(ranks_.size()));
  for (int r = 0; r < ranks_.size(); ++r) {
    const TreeNode terms = TermsOf(parts_.num_parts(), ranks_, r);
    counts.push_back(static_cast<std::size_t>(terms.end - terms.begin));
  }
  std::copy(mine.begin(), mine.end(), all.begin() + own_terms().begin);
  GatherInto(ranks_, std::span(all), counts);
  return SumByTree(all);
}

template <Backend B>
void DistributedProblem<B>::CheckSameStart(ConstVectorView x) {
  if (std::exchange(has_checked_start_, true)) return;
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a hash of the values
  for (const S value : x) {
    hash = (hash ^ static_cast<std::uint64_t>(
                       std::bit_cast<std::conditional_t<sizeof(S) == 8, std::uint64_t, std::uint32_t>>(value))) *
           1099511628211U;
  }
  const std::vector<std::uint64_t> all = GatherValues(ranks_, std::vector<std::uint64_t>{hash});
  for (std::size_t r = 1; r < all.size(); ++r) {
    if (all[r] != all[0])
      Fail(kBadArgument, "the start of process {} differs from process 0's; give all processes the same start", r);
  }
}

template <Backend B>
template <class CostOf>
double DistributedProblem<B>::SumCosts(ConstVectorView x, const CostOf& cost_of) {
  this->CheckSize(x);
  CheckSameStart(x);
  std::vector<double> costs;
  costs.reserve(own_.size());
  for (OwnPart<B>& part : own_) costs.push_back(cost_of(part.problem, Localize(x, part)));
  return SumNumbers(costs);
}

template <Backend B>
double DistributedProblem<B>::Cost(ConstVectorView x) {
  return SumCosts(x, [](const ProblemAdaptor<B>& part, ConstVectorView at) { return part.Cost(at); });
}

template <Backend B>
double DistributedProblem<B>::FixedCost(ConstVectorView x) {
  return SumCosts(x, [](const ProblemAdaptor<B>& part, ConstVectorView at) { return part.FixedCost(at); });
}

template <Backend B>
double DistributedProblem<B>::VariableCost(ConstVectorView x) {
  return SumCosts(x, [](const ProblemAdaptor<B>& part, ConstVectorView at) { return part.VariableCost(at); });
}

template <Backend B>
double DistributedProblem<B>::VariableNorm(ConstVectorView x) {
  B backend;
  return geometry_.VariableNorm(backend, x);
}

template <Backend B>
double DistributedProblem<B>::VariableMaxChange(ConstVectorView x, VectorView y) {
  B backend;
  return geometry_.VariableMaxChange(backend, x, y);
}

template <Backend B>
double DistributedProblem<B>::Cost(ConstVectorView x, std::span<const Index> units) {
  this->CheckSize(x);
  this->CheckUnits(units);
  std::vector<double> costs;
  costs.reserve(own_.size());
  for (OwnPart<B>& part : own_) {
    const auto from = std::lower_bound(units.begin(), units.end(), part.first_unit);
    const auto to = std::lower_bound(from, units.end(), part.first_unit + part.problem.num_units());
    std::vector<Index> of_part(from, to);
    for (Index& unit : of_part) unit -= part.first_unit;
    costs.push_back(of_part.empty() ? 0 : part.problem.Cost(Localize(x, part), of_part));
  }
  return SumNumbers(costs);
}

template <Backend B>
std::unique_ptr<Linearization<B>> DistributedProblem<B>::LinearizeBatch(ConstVectorView x, int batch) {
  this->CheckSize(x);
  this->CheckBatch(batch);
  return std::make_unique<DistributedLinearization<B>>(*this, x);
}

template <Backend B>
void DistributedProblem<B>::OnNewPoint(int turn) {
  for (OwnPart<B>& part : own_) part.problem.OnNewPoint(turn);
}

template <Backend B>
std::string DistributedProblem<B>::DescribeNonFinite(ConstVectorView x, bool jacobians) {
  std::string mine;
  for (Index term = own_terms().begin; term < own_terms().end && mine.empty(); ++term) {
    mine = part(term).problem.DescribeNonFinite(Localize(x, part(term)), jacobians);
    if (!mine.empty()) mine = fmt::format("part {}: {}", term, mine);
  }
  for (const std::string& words : GatherStrings(ranks_, mine)) {
    if (!words.empty()) return words;
  }
  return "";
}

// For host memory.
template class DistributedProblem<CpuBackend<double>>;
template class DistributedProblem<CpuBackend<float>>;

}  // namespace vesta
