// SPDX-License-Identifier: Apache-2.0
// Definitions of JointReducedSystem (joint_linearization.h). Include like joint_linearization.inl.
#pragma once

#include <algorithm>

#include "splatting/cameras/joint/joint_layout.h"
#include "splatting/cameras/joint/joint_linearization.h"

namespace vesta::gs {

template <Backend B>
JointReducedSystem<B>::JointReducedSystem(JointLinearization<B>& linearization)
    : linearization_(linearization), layout_(linearization.layout()), views_(layout_.num_tangent() - layout_.splats) {}

template <Backend B>
void JointReducedSystem<B>::SetDamping(double lambda, ConstVectorView metric) {
  lambda_ = lambda;
  metric_ = metric.subspan(0, layout_.splats);
  blocks_.clear();
  const int n = layout_.free.num_tangent();
  const ConstHostTail<B> of_views(metric, layout_.splats);
  std::ranges::copy(of_views.view(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    BlockDiagonal<CpuBackend<double>>& C = blocks_.emplace_back(n, std::vector<BlockGroup>{{.size = n, .count = 1}});
    FillBlock(linearization_.CurvatureOf(v), n, 0, 1, C.values(0));
    C.AddToDiagonal(lambda, ViewPart(v));
    C.Factorize();
  }
}

template <Backend B>
void JointReducedSystem<B>::ReduceRhs(ConstVectorView rhs, VectorView reduced) {
  B().Copy(rhs.subspan(0, layout_.splats), reduced);
  const ConstHostTail<B> of_views(rhs, layout_.splats);
  std::ranges::copy(of_views.view(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<B>& unit = linearization_.units()[v];
    const VectorView image = linearization_.scratch().Image(unit.values());
    B().Fill(0, image);
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), image.data());
    linearization_.AddSplatsJT(static_cast<Index>(v), image, reduced);
  }
}

template <Backend B>
void JointReducedSystem<B>::Apply(ConstVectorView x, VectorView y) {
  B().Fill(0, y);
  B().AddScaled(lambda_, metric_, x, y);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<B>& unit = linearization_.units()[v];
    const VectorView image = linearization_.scratch().Image(unit.values()),
                     weighted = linearization_.scratch().Weighted(unit.values());
    linearization_.ApplySplatsJ(static_cast<Index>(v), x, image);
    linearization_.ApplyW(unit, image, weighted);
    unit.weighted.Project(image.data(), ViewPart(v).data());
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), weighted.data());
    linearization_.AddSplatsJT(static_cast<Index>(v), weighted, y);
  }
}

template <Backend B>
void JointReducedSystem<B>::BackSubstitute(ConstVectorView rhs, VectorView step) {
  const ConstHostTail<B> rhs_rest(rhs, layout_.splats);
  HostTail<B> step_rest(ZeroInitialized(), step, layout_.splats);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<B>& unit = linearization_.units()[v];
    const VectorView image = linearization_.scratch().Image(unit.values());
    const HostSpan<double> part = ViewPart(v);
    linearization_.ApplySplatsJ(static_cast<Index>(v), step, image);
    unit.weighted.Project(image.data(), part.data());
    const HostSpan<const typename B::Scalar> own = layout_.StepOf(rhs_rest.view(), static_cast<Index>(v));
    for (Index k = 0; k < part.size(); ++k) part[k] = static_cast<double>(own[k]) - part[k];
    SolveView(v);
  }
  std::copy(views_.begin(), views_.end(), step_rest.view().begin());
  step_rest.Store();
}

template <Backend B>
std::vector<BlockGroup> JointReducedSystem<B>::kept_groups() const {
  std::vector<BlockGroup> groups = linearization_.block_groups();
  groups.pop_back();
  return groups;
}

template <Backend B>
void JointReducedSystem<B>::DiagonalBlocks(BlockDiagonal<B>& diagonal) {
  linearization_.Grams().CopyBlocks(diagonal);
  diagonal.AddToDiagonal(lambda_, metric_);
}

}  // namespace vesta::gs
