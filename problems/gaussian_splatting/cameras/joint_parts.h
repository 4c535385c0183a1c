// Splats, cameras, lenses and exposures cut into runs of views, to be spread over processes.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/cameras/joint_problem.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "solver/distributed/problem_parts.h"

namespace vesta::gs {

// Each part has all Gaussians and lenses, a run of the views, and their poses and exposures, which are eliminated part
// by part.
// Of views that fall to others nothing is looked at.
template <Backend B>
class JointParts final : public ProblemParts<B> {
 public:
  using Whole = JointProblem<B>;

  // As many as SplatParts has. whole must outlive this object.
  explicit JointParts(Whole& whole) : whole_(whole), layout_(whole.layout()) {}

  int num_parts() const override { return ViewRunsOf(layout_.views); }
  ProblemPart<B> Make(int part) override {
    const Share run = ViewsOfRun(layout_.views, part);
    const Index n = layout_.own().num_tangent(), shared = layout_.shared();
    return {whole_.MakePart(run), {}, {{0, 0, shared}, {shared, shared + run.begin * n, run.size() * n}}};
  }
  Index num_parameters() const override { return layout_.num_parameters(); }
  Index num_tangent() const override { return layout_.num_tangent(); }
  std::vector<BlockGroup> block_groups() const override { return whole_.block_groups(); }
  Problem<B>* geometry() override { return &whole_; }
  bool eliminates() const override { return whole_.eliminates_views(); }

 private:
  Whole& whole_;
  const JointLayout& layout_;
};

}  // namespace vesta::gs
