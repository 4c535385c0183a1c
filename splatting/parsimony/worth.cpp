// SPDX-License-Identifier: Apache-2.0
#include "splatting/parsimony/worth.h"

#include "splatting/parsimony/judging_views.h"

namespace vesta::gs {

Worth MeasureWorth(const splat::Model<float>& model, const JudgingViews& judges) {
  Worth worth;
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
