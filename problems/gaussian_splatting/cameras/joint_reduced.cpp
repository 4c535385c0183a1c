#include "problems/gaussian_splatting/cameras/joint_reduced.h"

#include <algorithm>

namespace vesta::gs {

template <class S>
JointReducedSystem<S>::JointReducedSystem(JointLinearization<S>& linearization)
    : linearization_(linearization),
      layout_(linearization.layout()),
      views_(layout_.num_tangent() - layout_.shared()) {}

template <class S>
void JointReducedSystem<S>::SetDamping(double lambda, ConstView metric) {
  lambda_ = lambda;
  metric_ = linearization_.is_part() ? ConstView() : metric.subspan(0, layout_.shared());
  blocks_.clear();
  const int n = layout_.own().num_tangent(), all = layout_.free.num_tangent();
  std::copy(metric.begin() + layout_.shared(), metric.end(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    BlockDiagonal<CpuBackend<double>>& C = blocks_.emplace_back(n, std::vector<BlockGroup>{{.size = n, .count = 1}});
    FillBlock(SquareOf(linearization_.CurvatureOf(v), all, 0, n), n, 0, 1, C.values(0));
    C.AddToDiagonal(lambda, ViewPart(v));
    C.Factorize();
  }
}

template <class S>
void JointReducedSystem<S>::ReduceRhs(ConstView rhs, View reduced) {
  B().Copy(rhs.subspan(0, layout_.shared()), reduced);
  std::copy(rhs.begin() + layout_.shared(), rhs.end(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values());
    B().Fill(0, image);
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), image.data());
    linearization_.AddSharedJT(static_cast<Index>(v), image, reduced);
  }
}

template <class S>
void JointReducedSystem<S>::Apply(ConstView x, View y) {
  B().Fill(0, y);
  if (!metric_.empty()) B().AddScaled(lambda_, metric_, x, y);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values()),
               weighted = linearization_.scratch().Weighted(unit.values());
    linearization_.ApplySharedJ(static_cast<Index>(v), x, image);
    linearization_.ApplyW(unit, image, weighted);
    unit.weighted.Project(image.data(), ViewPart(v).data());
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), weighted.data());
    linearization_.AddSharedJT(static_cast<Index>(v), weighted, y);
    linearization_.AddPriorOfLens(static_cast<Index>(v), x, y);
  }
}

template <class S>
void JointReducedSystem<S>::BackSubstitute(ConstView rhs, View step) {
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values());
    const HostSpan<double> part = ViewPart(v);
    linearization_.ApplySharedJ(static_cast<Index>(v), step, image);
    unit.weighted.Project(image.data(), part.data());
    const ConstView own = layout_.StepOf(rhs, static_cast<Index>(v));
    for (Index k = 0; k < part.size(); ++k) part[k] = static_cast<double>(own[k]) - part[k];
    SolveView(v);
  }
  std::copy(views_.begin(), views_.end(), step.begin() + layout_.shared());
}

template <class S>
std::vector<BlockGroup> JointReducedSystem<S>::kept_groups() const {
  std::vector<BlockGroup> groups = linearization_.block_groups();
  groups.pop_back();
  return groups;
}

template <class S>
std::vector<double> JointReducedSystem<S>::LensSchur(std::size_t view) {
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

template <class S>
void JointReducedSystem<S>::DiagonalBlocks(BlockDiagonal<B>& diagonal) {
  linearization_.Grams().CopyBlocks(diagonal);
  if (layout_.lenses > 0) {
    linearization_.AddLensBlocks([&](Index v) { return LensSchur(static_cast<std::size_t>(v)); },
                                 diagonal.values(static_cast<int>(diagonal.groups().size()) - 1));
  }
  if (!metric_.empty()) diagonal.AddToDiagonal(lambda_, metric_);
  if (linearization_.is_part()) linearization_.ReleaseGrams();
}

template class JointReducedSystem<float>;
template class JointReducedSystem<double>;

}  // namespace vesta::gs
