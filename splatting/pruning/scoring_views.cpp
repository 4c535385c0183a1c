// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/scoring_views.h"

#include <algorithm>

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

ScoringViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background,
                             const ProcessGroup& processes) {
  ScoringViews scoring_views{.views = {}, .background = background, .near = NearPlane(scene), .processes = processes};
  for (const View& view : scene.views) {
    if (view.is_trained()) scoring_views.views.push_back(&view);
  }
  return scoring_views;
}

RemovalCost MeasureRemovalCost(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  RemovalCost removal;
  removal.rise.resize(static_cast<std::size_t>(model.count));
  removal.largest_rise.resize(removal.rise.size());
  RenderedViews rendered(model, scoring_views);
  ScoringLoss loss;
  rendered.ForEachGathered<double>(
      [&](const View& view, double* rises) {
        rendered.view().AddRemovalRises(loss.Linearize(rendered.image(), view), rises, rendered.workspace());
      },
      [&](const View&) {
        return [&](Index i, double rise) {
          const auto k = static_cast<std::size_t>(i);
          removal.rise[k] += rise;
          removal.largest_rise[k] = std::max(removal.largest_rise[k], rise);
        };
      });
  removal.loss = loss.Cost(scoring_views), removal.values = loss.Values(scoring_views);
  return removal;
}

}  // namespace vesta::gs
