#include "problems/gaussian_splatting/cameras/joint_reduced.h"

#include <algorithm>

namespace vesta::gs {

template <class S>
JointReducedSystem<S>::JointReducedSystem(JointLinearization<S>& linearization)
    : linearization_(linearization),
      layout_(linearization.layout()),
      blocks_(layout_.num_tangent() - layout_.splats, {ViewBlocks(layout_, 0)}),
      views_(layout_.num_tangent() - layout_.splats) {
  Index largest = 0;
  for (const JointUnit<S>& unit : linearization.units()) largest = std::max(largest, unit.values());
  image_.ResizeForOverwrite(largest);
  weighted_.ResizeForOverwrite(largest);
}

template <class S>
void JointReducedSystem<S>::SetDamping(double lambda, ConstView metric) {
  lambda_ = lambda, metric_ = metric;
  FillViewBlocks(linearization_, blocks_.values(0));
  std::copy(metric.begin() + layout_.splats, metric.end(), views_.begin());
  blocks_.AddToDiagonal(lambda, views_);
  blocks_.Factorize();
}

template <class S>
void JointReducedSystem<S>::ReduceRhs(ConstView rhs, View reduced) {
  B().Copy(rhs.subspan(0, layout_.splats), reduced);
  std::copy(rhs.begin() + layout_.splats, rhs.end(), views_.begin());
  SolveViews(views_);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = image_.view().subspan(0, unit.values());
    B().Fill(0, image);
    unit.weighted.Add(-1, views_.data() + At(v), image.data());
    linearization_.AddSplatJT(unit, image, reduced.data());
  }
}

template <class S>
void JointReducedSystem<S>::Apply(ConstView x, View y) {
  B().Fill(0, y);
  B().AddScaled(lambda_, metric_.subspan(0, layout_.splats), x, y);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = image_.view().subspan(0, unit.values()), weighted = weighted_.view().subspan(0, unit.values());
    linearization_.ApplySplatJ(unit, x.data(), image);
    linearization_.ApplyW(unit, image, weighted);
    // By C^-1 of this view alone: the other views' entries are zero.
    std::fill(views_.begin(), views_.end(), 0.0);
    unit.weighted.Project(image.data(), views_.data() + At(v));
    SolveViews(views_);
    unit.weighted.Add(-1, views_.data() + At(v), weighted.data());
    linearization_.AddSplatJT(unit, weighted, y.data());
  }
}

template <class S>
void JointReducedSystem<S>::BackSubstitute(ConstView rhs, View step) {
  const auto n = static_cast<std::size_t>(layout_.free.num_tangent());
  std::vector<double> of_splats(n);
  for (std::size_t v = 0; v < linearization_.units().size(); ++v) {
    const JointUnit<S>& unit = linearization_.units()[v];
    const View image = image_.view().subspan(0, unit.values());
    linearization_.ApplySplatJ(unit, step.data(), image);
    unit.weighted.Project(image.data(), of_splats.data());
    for (std::size_t k = 0; k < n; ++k) {
      const Index at = At(v) + static_cast<Index>(k);
      views_[at] = static_cast<double>(rhs[layout_.splats + at]) - of_splats[k];
    }
  }
  SolveViews(views_);
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
  diagonal.AddToDiagonal(lambda_, metric_.subspan(0, layout_.splats));
}

template class JointReducedSystem<float>;
template class JointReducedSystem<double>;

}  // namespace vesta::gs
