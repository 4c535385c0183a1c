// Bodies of joint_reduced.h. Included where they are instantiated, as joint_linearization.inl.
#pragma once

#include <algorithm>

#include "problems/gaussian_splatting/cameras/joint_reduced.h"
#include "problems/gaussian_splatting/cameras/joint_rest.h"

namespace vesta::gs {

template <Backend B>
JointReducedSystem<B>::JointReducedSystem(JointLinearization<B>& linearization)
    : linearization_(linearization),
      layout_(linearization.layout()),
      views_(layout_.num_tangent() - layout_.shared()) {}

template <Backend B>
void JointReducedSystem<B>::SetDamping(double lambda, ConstView metric) {
  lambda_ = lambda;
  metric_ = linearization_.is_part() ? ConstView() : metric.subspan(0, layout_.shared());
  blocks_.clear();
  const int n = layout_.own().num_tangent(), all = layout_.free.num_tangent();
  const ConstRest<B> of_views(metric, layout_.shared());
  std::ranges::copy(of_views.view(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    BlockDiagonal<CpuBackend<double>>& C = blocks_.emplace_back(n, std::vector<BlockGroup>{{.size = n, .count = 1}});
    FillBlock(SquareOf(linearization_.CurvatureOf(v), all, 0, n), n, 0, 1, C.values(0));
    C.AddToDiagonal(lambda, ViewPart(v));
    C.Factorize();
  }
}

template <Backend B>
void JointReducedSystem<B>::ReduceRhs(ConstView rhs, View reduced) {
  B().Copy(rhs.subspan(0, layout_.shared()), reduced);
  const ConstRest<B> of_views(rhs, layout_.shared());
  std::ranges::copy(of_views.view(), views_.begin());
  Rest<B> reduced_rest(reduced, layout_.splats);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<B>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values());
    B().Fill(0, image);
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), image.data());
    linearization_.AddSharedJT(static_cast<Index>(v), image, reduced, reduced_rest.view());
  }
  reduced_rest.Store();
}

template <Backend B>
void JointReducedSystem<B>::Apply(ConstView x, View y) {
  B().Fill(0, y);
  if (!metric_.empty()) B().AddScaled(lambda_, metric_, x, y);
  const ConstRest<B> x_rest(x, layout_.splats);
  Rest<B> y_rest(y, layout_.splats);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<B>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values()),
               weighted = linearization_.scratch().Weighted(unit.values());
    linearization_.ApplySharedJ(static_cast<Index>(v), x, x_rest.view(), image);
    linearization_.ApplyW(unit, image, weighted);
    unit.weighted.Project(image.data(), ViewPart(v).data());
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), weighted.data());
    linearization_.AddSharedJT(static_cast<Index>(v), weighted, y, y_rest.view());
    linearization_.AddPriorOfLens(static_cast<Index>(v), x_rest.view(), y_rest.view());
  }
  y_rest.Store();
}

template <Backend B>
void JointReducedSystem<B>::BackSubstitute(ConstView rhs, View step) {
  const ConstRest<B> rhs_rest(rhs, layout_.splats);
  Rest<B> step_rest(step, layout_.splats);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<B>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values());
    const HostSpan<double> part = ViewPart(v);
    linearization_.ApplySharedJ(static_cast<Index>(v), step, step_rest.view(), image);
    unit.weighted.Project(image.data(), part.data());
    const HostSpan<const typename B::Scalar> own = layout_.StepOf(rhs_rest.view(), static_cast<Index>(v));
    for (Index k = 0; k < part.size(); ++k) part[k] = static_cast<double>(own[k]) - part[k];
    SolveView(v);
  }
  std::copy(views_.begin(), views_.end(), step_rest.view().begin() + (layout_.shared() - layout_.splats));
  step_rest.Store();
}

template <Backend B>
std::vector<BlockGroup> JointReducedSystem<B>::kept_groups() const {
  std::vector<BlockGroup> groups = linearization_.block_groups();
  groups.pop_back();
  return groups;
}

template <Backend B>
std::vector<double> JointReducedSystem<B>::LensSchur(std::size_t view) {
  const std::vector<double>& H = linearization_.CurvatureOf(view);
  const int own = layout_.own().num_tangent(), lens = layout_.free.lens_tangent(), all = own + lens;
  const auto at = [&](int row, int col) {
    return H[static_cast<std::size_t>(row) * static_cast<std::size_t>(all) + static_cast<std::size_t>(col)];
  };
  std::vector<double> schur;
  const HostSpan<double> part = ViewPart(view);
  for (int row = 0; row < lens; ++row) {
    for (int k = 0; k < own; ++k) part[k] = at(own + row, k);
    SolveView(view);
    for (int col = 0; col < lens; ++col) {
      double eliminated = 0;
      for (int k = 0; k < own; ++k) eliminated += part[k] * at(k, own + col);
      schur.push_back(at(own + row, own + col) - eliminated);
    }
  }
  return schur;
}

template <Backend B>
void JointReducedSystem<B>::DiagonalBlocks(BlockDiagonal<B>& diagonal) {
  linearization_.Grams().CopyBlocks(diagonal);
  if (layout_.lenses > 0) {
    linearization_.AddLensBlocks([&](Index v) { return LensSchur(static_cast<std::size_t>(v)); },
                                 diagonal.values(static_cast<int>(diagonal.groups().size()) - 1));
  }
  if (!metric_.empty()) diagonal.AddToDiagonal(lambda_, metric_);
  if (linearization_.is_part()) linearization_.ReleaseGrams();
}

}  // namespace vesta::gs
