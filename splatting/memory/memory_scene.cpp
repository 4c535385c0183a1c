// SPDX-License-Identifier: Apache-2.0
#include "splatting/memory/memory_scene.h"

#include <algorithm>

#include "kernels/gaussian_splatting/view/splat_view.h"
#include "solver/internal/trust_region/line_search.h"
#include "splatting/evaluate/quality.h"

namespace vesta::gs {

MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries) {
  const double background[3] = {0, 0, 0};
  splat::SplatView<float> view;
  splat::ViewWorkspace<float> workspace;
  std::vector<ViewCounts> counts(views.size());
  ViewCounts sum;
  const double share = std::min(1.0, static_cast<double>(most) / static_cast<double>(views.size()));
  const std::vector<Index> counted = SpreadUnits(static_cast<Index>(views.size()), share, 0);
  for (const Index v : counted) {
    view.Build(model, ToPosedCamera(*views[static_cast<std::size_t>(v)], near), background, workspace);
    sum.splats += static_cast<double>(view.num_splats());
    sum.pairs += static_cast<double>(view.num_pairs());
    const double entries = with_entries ? static_cast<double>(view.CountVisits().pixels) : 0;
    sum.entries += entries;
    counts[static_cast<std::size_t>(v)] = {.splats = static_cast<double>(view.num_splats()),
                                           .pairs = static_cast<double>(view.num_pairs()),
                                           .entries = entries};
  }
  const auto number = static_cast<double>(counted.size());
  for (std::size_t v = 0, next = 0; v < views.size(); ++v) {
    if (next < counted.size() && counted[next] == static_cast<Index>(v)) {
      ++next;
    } else {
      counts[v] = {.splats = sum.splats / number, .pairs = sum.pairs / number, .entries = sum.entries / number};
    }
    const Camera& camera = views[v]->camera;
    const auto tiles = [](int size) { return (size + splat::kTileSize - 1) / splat::kTileSize; };
    counts[v].pixels = camera.pixels();
    counts[v].tiles = static_cast<double>(tiles(camera.width)) * tiles(camera.height);
  }
  double mask_bytes = 0;
  for (const View* v : views) mask_bytes += static_cast<double>(v->image.mask.size());
  return {.layout = model, .views = std::move(counts), .mask_bytes = mask_bytes};
}

MemoryScene MemoryScene::Scaled(Index new_gaussians) const {
  const double factor = static_cast<double>(new_gaussians) / static_cast<double>(std::max<Index>(layout.count, 1));
  MemoryScene scene = *this;
  scene.layout.count = new_gaussians;
  for (std::int64_t& lacking : scene.layout.lacking)
    lacking = static_cast<Index>(factor * static_cast<double>(lacking));
  for (ViewCounts& view : scene.views) view.splats *= factor, view.pairs *= factor, view.entries *= factor;
  return scene;
}

MemoryScene MemoryScene::Of(const splat::ModelLayout& other) const {
  MemoryScene scene = Scaled(other.count);
  scene.layout = other;
  return scene;
}

ViewCounts MemoryScene::Largest() const {
  ViewCounts most;
  for (const ViewCounts& view : views) {
    most.pixels = std::max(most.pixels, view.pixels), most.tiles = std::max(most.tiles, view.tiles);
    most.splats = std::max(most.splats, view.splats), most.pairs = std::max(most.pairs, view.pairs);
  }
  return most;
}

const schema::Table<MemoryOptions>& MemoryFields() {
  using O = MemoryOptions;
  static const schema::Table<O> fields = {
      {"budget_gib",
       &O::budget_gib,
       {0, 1e6},
       "GiB that the program may take (of the GPU with one), foreseen before they are used; 0: no limit",
       "memory_budget"},
  };
  return fields;
}

}  // namespace vesta::gs
