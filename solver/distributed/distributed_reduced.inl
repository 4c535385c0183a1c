// SPDX-License-Identifier: Apache-2.0
// Bodies of solver/distributed/distributed_reduced.h.
#pragma once

#include <utility>

#include "kernels/core/check.h"
#include "solver/distributed/distributed_linearization.h"
#include "solver/distributed/distributed_reduced.h"

namespace vesta {

template <Backend B>
DistributedReducedSystem<B>::DistributedReducedSystem(DistributedLinearization<B>& linearization)
    : linearization_(linearization), problem_(linearization.problem()) {
  const TreeNode terms = problem_.own_terms();
  for (Index term = terms.begin; term < terms.end; ++term) {
    auto system = linearization.of(term).MakeReducedSystem();
    if (!system)
      Fail(kUnsupported, "part {} has no group to eliminate; ProblemParts::eliminates says that all have", term);
    if (term == terms.begin) kept_ = system->size();
    const Support& support = problem_.part(term).tangent.support();
    const bool keeps_first =
        system->size() == kept_ && support.CountBefore(kept_) == kept_ && problem_.part(term).tangent.is_compact();
    if (!keeps_first)
      Fail(kBadArgument, "part {} keeps {} parameters that are not the first of the problem", term, system->size());
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
  // What each part eliminated is its own: processes hand round what they have, and nothing is summed.
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

}  // namespace vesta
