// Bodies of solver/distributed/distributed_linearization.h.
#pragma once

#include <utility>

#include "kernels/core/check.h"
#include "solver/distributed/distributed_linearization.h"
#include "solver/distributed/distributed_reduced.h"

namespace vesta {

template <Backend B>
DistributedLinearization<B>::DistributedLinearization(DistributedProblem<B>& problem, ConstView x) : problem_(problem) {
  Index residuals = 0;
  for (OwnPart<B>& part : problem.own()) {
    ConstView at = x;
    if (!part.parameters.is_identity()) {
      typename B::Vector& own = x_.emplace_back();
      own.ResizeForOverwrite(part.parameters.local_size());
      part.parameters.template Take<S>(x, own.view());
      at = own.view();
    }
    linearizations_.push_back(part.problem->CheckedLinearize(at, 0));
    residuals += linearizations_.back()->num_residuals();
    has_own_descent_ = linearizations_.back()->has_own_descent();
  }
  for (const Index of_rank : GatherValues(problem.ranks(), std::vector<Index>{residuals})) num_residuals_ += of_rank;
}

template <Backend B>
auto DistributedLinearization<B>::residuals() const -> ConstView {
  Fail("no process has all residuals of a distributed problem: choose PCG, and check derivatives part by part");
}

template <Backend B>
void DistributedLinearization<B>::ApplyJ(ConstView, View) {
  residuals();
}

template <Backend B>
void DistributedLinearization<B>::ApplyJT(ConstView, View) {
  residuals();
}

template <Backend B>
auto DistributedLinearization<B>::Localize(ConstView v, const PartMap& map, typename B::Vector& local) const
    -> ConstView {
  if (map.is_identity()) return v;
  local.ResizeForOverwrite(map.local_size());
  map.template Take<S>(v, local.view());
  return local.view();
}

template <Backend B>
template <class Give>
void DistributedLinearization<B>::SumParts(const Give& give, View out) {
  problem_.tangent_sum().Sum(
      [&](Index term, View to) {
        const OwnPart<B>& part = problem_.part(term);
        if (part.tangent.is_compact()) return give(of(term), part, to);
        local_out_.ResizeForOverwrite(part.tangent.local_size());
        give(of(term), part, local_out_.view());
        part.tangent.template MakeCompact<S>(std::as_const(local_out_).view(), to);
      },
      out);
}

// Where the descent is of both, gradients and their squares in one pass, as one vector: so a part need not keep the one
// while the other is summed.
template <Backend B>
void DistributedLinearization<B>::SumGradients() {
  const Index n = num_parameters();
  gradient_.ResizeForOverwrite(n);
  if (!has_own_descent_) {
    SumParts([](Linearization<B>& linearization, const OwnPart<B>&, View to) { linearization.Gradient(to); },
             gradient_);
    return;
  }
  std::vector<Support> supports;
  supports.reserve(problem_.own().size());
  for (const OwnPart<B>& part : problem_.own()) {
    if (!part.tangent.is_identity()) Fail("parts with a descent of their own must have all parameters");
    supports.push_back(Support::All(2 * n));
  }
  SumOverRanks<S> sum(problem_.ranks(), problem_.parts().num_parts(), 2 * n, supports);
  typename B::Vector both;
  both.ResizeForOverwrite(2 * n);
  sum.Sum(
      [&](Index term, View to) {
        of(term).Gradient(to.subspan(0, n));
        of(term).SquaredGradients(to.subspan(n, n));
      },
      both);
  squares_.ResizeForOverwrite(n);
  B().Copy(both.view().subspan(0, n), gradient_);
  B().Copy(both.view().subspan(n, n), squares_);
}

template <Backend B>
void DistributedLinearization<B>::Gradient(View g) {
  if (gradient_.empty()) SumGradients();
  B().Copy(gradient_, g);
  if (!has_own_descent_) gradient_ = {};
}

template <Backend B>
void DistributedLinearization<B>::Descent(View d) {
  if (!has_own_descent_) return Base::Descent(d);
  if (gradient_.empty()) SumGradients();
  B().Copy(squares_, d);
  linearizations_.front()->DescentOf(problem_.num_units(), gradient_, d);
  gradient_ = {}, squares_ = {};
}

template <Backend B>
void DistributedLinearization<B>::DiagJTJ(View d) {
  if (!linearizations_.front()->blocks_give_diagonal()) {
    SumParts([](Linearization<B>& linearization, const OwnPart<B>&, View to) { linearization.DiagJTJ(to); }, d);
    return;
  }
  blocks_.emplace(num_parameters(), block_groups());
  SumBlocks(*blocks_);
  blocks_->Diagonal(d);
}

template <Backend B>
void DistributedLinearization<B>::BlockGram(BlockDiagonal<B>& blocks) {
  if (!blocks_) return SumBlocks(blocks);
  B().Copy(blocks_->all_values(), blocks.all_values());
  blocks_.reset();  // nobody asks again unless a step is refused
}

template <Backend B>
void DistributedLinearization<B>::ApplyH(ConstView v, View Hv) {
  SumParts([&](Linearization<B>& linearization, const OwnPart<B>& part,
               View to) { linearization.ApplyH(Localize(v, part.tangent, local_in_), to); },
           Hv);
}

template <Backend B>
double DistributedLinearization<B>::Curvature(ConstView v) {
  std::vector<double> mine;
  for (Index term = problem_.own_terms().begin; term < problem_.own_terms().end; ++term) {
    mine.push_back(of(term).Curvature(Localize(v, problem_.part(term).tangent, local_in_)));
  }
  return problem_.SumNumbers(mine);
}

template <Backend B>
void DistributedLinearization<B>::SumBlocks(BlockDiagonal<B>& blocks) {
  std::vector<PartMap> maps;
  std::vector<Support> supports;
  for (Index term = problem_.own_terms().begin; term < problem_.own_terms().end; ++term) {
    const std::vector<BlockGroup> groups = of(term).block_groups();
    Index values = 0;
    for (const BlockGroup& group : groups) values += group.NumValues();
    maps.emplace_back(BlockSegments(groups, blocks.groups(), problem_.part(term).tangent_segments), values,
                      blocks.all_values().size(), "values of blocks");
    supports.push_back(maps.back().support());
  }
  SumOverRanks<S> sum(problem_.ranks(), problem_.parts().num_parts(), blocks.all_values().size(), supports);
  sum.Sum(
      [&](Index term, View to) {
        BlockDiagonal<B> of_part(of(term).num_parameters(), of(term).block_groups());
        of(term).BlockGram(of_part);
        maps[static_cast<std::size_t>(term - problem_.own_terms().begin)].template MakeCompact<S>(of_part.all_values(),
                                                                                                  to);
      },
      blocks.all_values());
}

template <Backend B>
std::unique_ptr<ReducedSystem<B>> DistributedLinearization<B>::MakeReducedSystem() {
  if (!problem_.parts().eliminates()) return nullptr;
  return std::make_unique<DistributedReducedSystem<B>>(*this);
}

}  // namespace vesta
