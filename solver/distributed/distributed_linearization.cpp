// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/distributed_linearization.h"

#include <utility>

#include "kernels/core/check.h"

namespace vesta {

template <Backend B>
DistributedLinearization<B>::DistributedLinearization(DistributedProblem<B>& problem, ConstVectorView x)
    : problem_(problem) {
  Index residuals = 0;
  for (OwnPart<B>& part : problem.own()) {
    x_.emplace_back();
    const ConstVectorView at = part.parameters.template Local<S>(x, x_.back());
    linearizations_.push_back(part.problem.CheckedLinearize(at, 0));
    residuals += linearizations_.back()->num_residuals();
    has_own_right_hand_side_ = linearizations_.back()->has_own_right_hand_side();
  }
  for (const Index of_rank : GatherValues(problem.ranks(), std::vector<Index>{residuals})) num_residuals_ += of_rank;
}

template <Backend B>
auto DistributedLinearization<B>::residuals() const -> ConstVectorView {
  Fail(kUnsupported,
       "no process has all residuals of a distributed problem; choose PCG, and check derivatives part by part");
}

template <Backend B>
void DistributedLinearization<B>::ApplyJ(ConstVectorView, VectorView) {
  residuals();
}

template <Backend B>
void DistributedLinearization<B>::ApplyJT(ConstVectorView, VectorView) {
  residuals();
}

template <Backend B>
void DistributedLinearization<B>::ApplyW(ConstVectorView, VectorView) {
  residuals();
}

template <Backend B>
template <class Give>
auto DistributedLinearization<B>::Term(const Give& give) {
  return [this, &give](Index term, VectorView to) {
    const OwnPart<B>& part = problem_.part(term);
    if (part.tangent.is_compact()) return give(of(term), part, to);
    local_out_.ResizeForOverwrite(part.tangent.local_size());
    give(of(term), part, local_out_.view());
    part.tangent.template MakeCompact<S>(std::as_const(local_out_).view(), to);
  };
}

template <Backend B>
template <class Give>
void DistributedLinearization<B>::SumParts(const Give& give, VectorView out) {
  problem_.tangent_sum().Sum(Term(give), out);
}

// The problem's own right-hand side needs the gradients and the sums of their squares. Both are summed as one vector,
// so a part need not store one while the other is summed.
template <Backend B>
void DistributedLinearization<B>::SumGradients() {
  const Index n = num_parameters();
  gradient_.ResizeForOverwrite(n);
  if (!has_own_right_hand_side_) {
    SumParts(
        [](LinearizationAdaptor<B>& linearization, const OwnPart<B>&, VectorView to) { linearization.Gradient(to); },
        gradient_);
    return;
  }
  std::vector<Support> supports;
  supports.reserve(problem_.own().size());
  for (const OwnPart<B>& part : problem_.own()) supports.push_back(RepeatSupport(part.tangent.support(), n));
  SumOverRanks<S> sum(problem_.ranks(), problem_.parts().num_parts(), 2 * n, supports);
  typename B::Vector both;
  both.ResizeForOverwrite(2 * n);
  const auto gradient = [](LinearizationAdaptor<B>& part, const OwnPart<B>&, VectorView to) { part.Gradient(to); };
  const auto squares = [](LinearizationAdaptor<B>& part, const OwnPart<B>&, VectorView to) {
    part.SquaredGradients(to);
  };
  sum.Sum(
      [&](Index term, VectorView to) {
        const Index half = to.size() / 2;
        Term(gradient)(term, to.subspan(0, half));
        Term(squares)(term, to.subspan(half, half));
      },
      both);
  squares_.ResizeForOverwrite(n);
  B().Copy(both.view().subspan(0, n), gradient_);
  B().Copy(both.view().subspan(n, n), squares_);
}

template <Backend B>
void DistributedLinearization<B>::Gradient(VectorView g) {
  if (gradient_.empty()) SumGradients();
  B().Copy(gradient_, g);
  if (!has_own_right_hand_side_) gradient_ = {};
}

template <Backend B>
void DistributedLinearization<B>::RightHandSide(VectorView d) {
  VESTA_CHECK(has_own_right_hand_side_, "RightHandSide needs parts with their own right-hand side");
  if (gradient_.empty()) SumGradients();
  B().Copy(squares_, d);
  linearizations_.front()->RightHandSideOf(problem_.num_units(), gradient_, d);
  gradient_ = {}, squares_ = {};
}

template <Backend B>
void DistributedLinearization<B>::DiagJTJ(VectorView d) {
  if (!linearizations_.front()->blocks_give_diagonal()) {
    SumParts(
        [](LinearizationAdaptor<B>& linearization, const OwnPart<B>&, VectorView to) { linearization.DiagJTJ(to); }, d);
    return;
  }
  const Shards& shards = problem_.shards();
  blocks_.emplace(shards.own().size(), shards.groups());
  SumBlocks(shards.BlockValuesOfRanks(), blocks_->all_values());
  typename B::Vector shard(shards.own().size()), storage;
  blocks_->Diagonal(shard);
  shards.Gather<S>(std::as_const(shard).view(), d, storage);
}

template <Backend B>
void DistributedLinearization<B>::BlockGram(BlockDiagonal<B>& blocks) {
  SumBlocks({}, blocks.all_values());
}

template <Backend B>
void DistributedLinearization<B>::ShardOfBlocks(BlockDiagonal<B>& blocks) {
  if (!blocks_) return SumBlocks(problem_.shards().BlockValuesOfRanks(), blocks.all_values());
  B().Copy(blocks_->all_values(), blocks.all_values());
  blocks_.reset();  // needed again only after a rejected step
}

template <Backend B>
void DistributedLinearization<B>::ApplyH(ConstVectorView v, VectorView Hv) {
  SumParts(ProductWith(v), Hv);
}

template <Backend B>
void DistributedLinearization<B>::ApplyHToShard(ConstVectorView v, VectorView shard) {
  const auto product = ProductWith(v);
  problem_.shard_sum().SumShare(Term(product), shard);
}

template <Backend B>
double DistributedLinearization<B>::Curvature(ConstVectorView v) {
  std::vector<double> mine;
  for (Index term = problem_.own_terms().begin; term < problem_.own_terms().end; ++term) {
    mine.push_back(of(term).Curvature(problem_.part(term).tangent.template Local<S>(v, local_in_)));
  }
  return problem_.SumNumbers(mine);
}

template <Backend B>
void DistributedLinearization<B>::SumBlocks(std::vector<Support> finished, VectorView values) {
  const std::vector<BlockGroup> whole = block_groups();
  Index size = 0;
  for (const BlockGroup& group : whole) size += group.NumValues();
  const bool is_shard = !finished.empty();
  std::vector<PartMap> maps;
  std::vector<Support> supports;
  for (Index term = problem_.own_terms().begin; term < problem_.own_terms().end; ++term) {
    const std::vector<BlockGroup> groups = of(term).block_groups();
    Index of_part = 0;
    for (const BlockGroup& group : groups) of_part += group.NumValues();
    maps.emplace_back(BlockSegments(groups, whole, problem_.part(term).tangent), of_part, size, "values of blocks");
    supports.push_back(maps.back().support());
  }
  SumOverRanks<S> sum(problem_.ranks(), problem_.parts().num_parts(), size, supports, std::move(finished));
  const auto write = [&](Index term, VectorView to) {
    BlockDiagonal<B> of_part(of(term).num_parameters(), of(term).block_groups());
    of(term).BlockGram(of_part);
    maps[static_cast<std::size_t>(term - problem_.own_terms().begin)].template MakeCompact<S>(of_part.all_values(), to);
  };
  is_shard ? sum.SumShare(write, values) : sum.Sum(write, values);
}

template <Backend B>
std::unique_ptr<ReducedSystem<B>> DistributedLinearization<B>::MakeReducedSystem() {
  if (!problem_.parts().eliminates()) return nullptr;
  return std::make_unique<DistributedReducedSystem<B>>(*this);
}

template <Backend B>
std::unique_ptr<ShardedSystem<B>> DistributedLinearization<B>::MakeShardedSystem() {
  problem_.tangent_sum().Release();  // later sums are over shards
  return std::make_unique<DistributedShards<B>>(*this);
}

template <Backend B>
DistributedReducedSystem<B>::DistributedReducedSystem(DistributedLinearization<B>& linearization)
    : linearization_(linearization), problem_(linearization.problem()) {
  const TreeNode terms = problem_.own_terms();
  for (Index term = terms.begin; term < terms.end; ++term) {
    auto system = linearization.of(term).MakeReducedSystem();
    if (!system)
      Fail(kUnsupported, "part {} has no group to eliminate, but ProblemParts::eliminates is true; return false there",
           term);
    if (term == terms.begin) kept_ = system->size();
    const Support& support = problem_.part(term).tangent.support();
    const bool keeps_first =
        system->size() == kept_ && support.CountBefore(kept_) == kept_ && problem_.part(term).tangent.is_compact();
    if (!keeps_first)
      Fail(kBadArgument, "part {} keeps {} parameters, which are not the first ones of the problem; order them first",
           term, system->size());
    systems_.push_back(std::move(system));
  }
  kept_sum_ = std::make_unique<SumOverRanks<S>>(problem_.ranks(), problem_.parts().num_parts(), kept_,
                                                std::vector<Support>(systems_.size(), Support::All(kept_)));
}

template <Backend B>
auto DistributedReducedSystem<B>::LocalizeEliminated(ConstVectorView v, const PartMap& map) -> ConstVectorView {
  local_.ResizeForOverwrite(map.local_size());
  map.template Take<S>(v, local_.view());
  B().Fill(0, local_.view().subspan(0, kept_));
  return local_.view();
}

template <Backend B>
void DistributedReducedSystem<B>::SetDamping(double lambda, ConstVectorView metric) {
  lambda_ = lambda;
  metric_ = metric;
  for (std::size_t k = 0; k < systems_.size(); ++k) {
    systems_[k]->SetDamping(lambda, LocalizeEliminated(metric, problem_.own()[k].tangent));
  }
}

template <Backend B>
void DistributedReducedSystem<B>::ReduceRhs(ConstVectorView rhs, VectorView reduced) {
  const Index first = problem_.own_terms().begin;
  kept_sum_->Sum(
      [&](Index term, VectorView to) {
        const auto k = static_cast<std::size_t>(term - first);
        systems_[k]->ReduceRhs(LocalizeEliminated(rhs, problem_.own()[k].tangent), to);
      },
      reduced);
  B().Axpby(1.0, rhs.subspan(0, kept_), 1.0, reduced);
}

template <Backend B>
void DistributedReducedSystem<B>::Apply(ConstVectorView x, VectorView y) {
  const Index first = problem_.own_terms().begin;
  kept_sum_->Sum([&](Index term, VectorView to) { systems_[static_cast<std::size_t>(term - first)]->Apply(x, to); }, y);
  B().AddScaled(lambda_, metric_.subspan(0, kept_), x, y);
}

template <Backend B>
void DistributedReducedSystem<B>::BackSubstitute(ConstVectorView rhs, VectorView step) {
  // Each eliminated parameter belongs to one part, so the processes exchange entries without summing.
  std::vector<S> mine;
  for (std::size_t k = 0; k < systems_.size(); ++k) {
    const PartMap& map = problem_.own()[k].tangent;
    local_step_.ResizeForOverwrite(map.local_size());
    map.template Take<S>(step, local_step_.view());
    local_.ResizeForOverwrite(map.local_size());
    map.template Take<S>(rhs, local_.view());
    systems_[k]->BackSubstitute(local_, local_step_);
    mine.insert(mine.end(), local_step_.begin() + kept_, local_step_.end());
  }
  const std::vector<S> all = GatherValues(problem_.ranks(), mine);
  const S* from = all.data();
  for (Index term = 0; term < problem_.parts().num_parts(); ++term) {
    for (const EntryRange& range : problem_.tangent_sum().plan().Of({term, term + 1}).ranges()) {
      const Index begin = std::max(range.begin, kept_);
      for (Index entry = begin; entry < range.end; ++entry) step[entry] = *from++;
    }
  }
}

template <Backend B>
void DistributedReducedSystem<B>::DiagonalBlocks(BlockDiagonal<B>& blocks) {
  const Index first = problem_.own_terms().begin, values = blocks.all_values().size();
  SumOverRanks<S> sum(problem_.ranks(), problem_.parts().num_parts(), values,
                      std::vector<Support>(systems_.size(), Support::All(values)));
  sum.Sum(
      [&](Index term, VectorView to) {
        BlockDiagonal<B> of_part(kept_, blocks.groups());
        systems_[static_cast<std::size_t>(term - first)]->DiagonalBlocks(of_part);
        B().Copy(of_part.all_values(), to);
      },
      blocks.all_values());
  blocks.AddToDiagonal(lambda_, metric_.subspan(0, kept_));
}

// For host memory.
template class DistributedLinearization<CpuBackend<double>>;
template class DistributedLinearization<CpuBackend<float>>;
template class DistributedReducedSystem<CpuBackend<double>>;
template class DistributedReducedSystem<CpuBackend<float>>;

}  // namespace vesta
