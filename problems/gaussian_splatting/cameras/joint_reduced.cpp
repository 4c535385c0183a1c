#include "problems/gaussian_splatting/cameras/joint_reduced.h"

#include <algorithm>

namespace vesta::gs {

template <class S>
JointReducedSystem<S>::JointReducedSystem(JointLinearization<S>& linearization)
    : linearization_(linearization), layout_(linearization.layout()), views_(layout_.num_tangent() - layout_.splats) {}

template <class S>
void JointReducedSystem<S>::SetDamping(double lambda, ConstView metric) {
  lambda_ = lambda;
  metric_ = linearization_.is_part() ? ConstView() : metric.subspan(0, layout_.splats);
  blocks_.clear();
  const int n = layout_.free.num_tangent();
  std::copy(metric.begin() + layout_.splats, metric.end(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    BlockDiagonal<CpuBackend<double>>& C = blocks_.emplace_back(n, std::vector<BlockGroup>{{.size = n, .count = 1}});
    FillBlock(linearization_.CurvatureOf(v), n, 0, 1, C.values(0));
    C.AddToDiagonal(lambda, ViewPart(v));
    C.Factorize();
  }
}

template <class S>
void JointReducedSystem<S>::ReduceRhs(ConstView rhs, View reduced) {
  B().Copy(rhs.subspan(0, layout_.splats), reduced);
  std::copy(rhs.begin() + layout_.splats, rhs.end(), views_.begin());
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values());
    B().Fill(0, image);
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), image.data());
    linearization_.AddSplatJT(unit, image, reduced.data());
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
    linearization_.ApplySplatJ(unit, x.data(), image);
    linearization_.ApplyW(unit, image, weighted);
    unit.weighted.Project(image.data(), ViewPart(v).data());
    SolveView(v);
    unit.weighted.Add(-1, ViewPart(v).data(), weighted.data());
    linearization_.AddSplatJT(unit, weighted, y.data());
  }
}

template <class S>
void JointReducedSystem<S>::BackSubstitute(ConstView rhs, View step) {
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = linearization_.scratch().Image(unit.values());
    const HostSpan<double> part = ViewPart(v);
    linearization_.ApplySplatJ(unit, step.data(), image);
    unit.weighted.Project(image.data(), part.data());
    const ConstView own = layout_.StepOf(rhs, static_cast<Index>(v));
    for (Index k = 0; k < part.size(); ++k) part[k] = static_cast<double>(own[k]) - part[k];
    SolveView(v);
  }
  std::copy(views_.begin(), views_.end(), step.begin() + layout_.splats);
}

template <class S>
std::vector<BlockGroup> JointReducedSystem<S>::kept_groups() const {
  std::vector<BlockGroup> groups = linearization_.block_groups();
  groups.pop_back();
  return groups;
}

template <class S>
void JointReducedSystem<S>::DiagonalBlocks(BlockDiagonal<B>& diagonal) {
  linearization_.Grams().CopyBlocks(diagonal);
  if (!metric_.empty()) diagonal.AddToDiagonal(lambda_, metric_);
  if (linearization_.is_part()) linearization_.ReleaseGrams();
}

template class JointReducedSystem<float>;
template class JointReducedSystem<double>;

}  // namespace vesta::gs
