// The splatting problem cut into runs of views, to be spread over processes. For every memory space that distributed
// problems are for.
#pragma once

#include "kernels/core/check.h"
#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "solver/distributed/problem_parts.h"

namespace vesta::gs {

// Throws Error where views are in several batches, or in some that change from turn to turn.
inline void CheckOneBatch(const ViewBatchOptions& batches) {
  if (batches.count > 1 || batches.size > 0) {
    Fail("LM over several processes takes all views as one batch; leave lm.batches=1 and lm.batch_size=0");
  }
}

// Each part has all Gaussians and a run of the views. Of views that fall to others nothing is looked at.
template <Backend B>
class SplatParts final : public ProblemParts<B> {
 public:
  using Whole = SplatProblem<B>;

  // No more parts than there are views, and as many whatever the number of processes is. whole must outlive this
  // object. Throws Error as CheckOneBatch does.
  explicit SplatParts(Whole& whole) : whole_(whole), num_parts_(ViewRunsOf(static_cast<Index>(whole.views().size()))) {
    CheckOneBatch(whole.options().batches);
  }

  int num_parts() const override { return num_parts_; }
  ProblemPart<B> Make(int part) override {
    const Share run = ViewsOfRun(static_cast<Index>(whole_.views().size()), part);
    return {whole_.MakePart(
                whole_.views().subspan(static_cast<std::size_t>(run.begin), static_cast<std::size_t>(run.size()))),
            {},
            {}};
  }
  Index num_parameters() const override { return whole_.num_parameters(); }
  std::vector<BlockGroup> block_groups() const override { return SplatBlockGroups(whole_.options()); }
  Problem<B>* geometry() override { return &whole_; }

 private:
  Whole& whole_;
  int num_parts_;
};

}  // namespace vesta::gs
