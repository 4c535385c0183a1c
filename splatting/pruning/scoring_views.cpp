// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/scoring_views.h"

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

ScoringViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background,
                             const ProcessGroup& processes) {
  ScoringViews judges{.views = {}, .background = background, .near = NearPlane(scene), .processes = processes};
  for (const View& view : scene.views) {
    if (view.is_trained()) judges.views.push_back(&view);
  }
  return judges;
}

RemovalCost MeasureRemovalCost(const splat::Model<float>& model, const ScoringViews& judges) {
  RemovalCost worth;
  worth.rise.resize(static_cast<std::size_t>(model.count));
  RenderedViews rendered(model, judges);
  JudgedLoss judged;
  rendered.ForEachAnswer<double>(
      [&](const View& view, double* rises) {
        rendered.view().AddRemovals(judged.Linearize(rendered.image(), view), rises, rendered.workspace());
      },
      [&](const View&) { return [&](Index i, double rise) { worth.rise[static_cast<std::size_t>(i)] += rise; }; });
  worth.cost = judged.Cost(judges), worth.values = judged.Values(judges);
  return worth;
}

}  // namespace vesta::gs
