// SPDX-License-Identifier: Apache-2.0
// The splatting problem of the LM stage as a sum of parts, divided among processes. Each part has some consecutive
// views.
#pragma once

#include <algorithm>
#include <memory>
#include <type_traits>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/distributed/problem_parts.h"
#include "splatting/distributed/process_group.h"

namespace vesta::gs {

// One part per view, but at most 64. This number must not depend on the number of processes, because it determines the
// order of sums.
inline int NumSplatParts(Index views) {
  constexpr Index kMost = 64;
  return static_cast<int>(std::clamp<Index>(views, 1, kMost));
}

// Throws Error if the options divide the views into batches.
inline void CheckOneBatch(const ViewBatchOptions& batches) {
  if (batches.count > 1 || batches.size > 0) {
    Fail(kUnsupported,
         "LM over several processes takes all views as one batch; leave lm.batches=1 and lm.batch_size=0");
  }
}

// Each part has all Gaussians.
class SplatParts final : public ProblemParts<CpuBackend<float>> {
 public:
  using B = CpuBackend<float>;

  // whole: the problem with all views; must outlive this object. Throws Error as CheckOneBatch.
  explicit SplatParts(SplatProblem<B>& whole) : whole_(whole) { CheckOneBatch(whole.options().batches); }

  int num_parts() const override { return NumSplatParts(num_views()); }
  ProblemPart<B> Make(int part) override {
    const Share run = ShareOf(num_views(), num_parts(), part);
    const auto views =
        whole_.views().subspan(static_cast<std::size_t>(run.begin), static_cast<std::size_t>(run.size()));
    return {whole_.MakePart(views), {}, {}};
  }
  Index num_parameters() const override { return whole_.num_parameters(); }
  std::vector<BlockGroup> block_groups() const override { return SplatBlockGroups(whole_.options()); }
  Problem<B>* geometry() override { return &whole_; }

 private:
  Index num_views() const { return static_cast<Index>(whole_.views().size()); }

  SplatProblem<B>& whole_;
};

// The problem to solve: `whole` on a GPU or without a launcher such as mpirun. Otherwise a DistributedProblem, even for
// a single process, so that the order of sums is always the same.
template <Backend B>
class ProblemToSolve {
 public:
  ProblemToSolve(const ProcessGroup& processes, SplatProblem<B>& whole) : solved_(&whole) {
    if constexpr (std::is_same_v<B, Cpu>) {
      if (!processes.ranks()) return;
      parts_ = std::make_unique<SplatParts>(whole);
      distributed_ = std::make_unique<DistributedProblem<Cpu>>(*processes.ranks(), *parts_);
      solved_ = distributed_.get();
    }
  }
  Problem<B>& operator*() { return *solved_; }

 private:
  using Cpu = CpuBackend<float>;

  Problem<B>* solved_;
  std::unique_ptr<SplatParts> parts_;
  std::unique_ptr<DistributedProblem<Cpu>> distributed_;
};

}  // namespace vesta::gs
