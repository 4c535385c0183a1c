// SPDX-License-Identifier: Apache-2.0
#include "apps/inputs/splat_filters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "apps/cli/outputs.h"
#include "apps/inputs/scene_and_splat.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/pruning/coverage.h"

namespace vesta::app {
namespace {

std::optional<gs::Box> BoxOf(const Flags& flags) {
  if (flags.box.empty()) return std::nullopt;
  const std::vector<std::string> texts = schema::SplitAt(flags.box, ',');
  std::array<double, 6> ends{};
  bool is_box = texts.size() == ends.size();
  for (std::size_t k = 0; is_box && k < ends.size(); ++k) {
    is_box = ParseNumber(texts[k], &ends[k]) && std::isfinite(ends[k]);
  }
  for (std::size_t k = 0; is_box && k < 3; ++k) is_box = ends[k] < ends[3 + k];
  if (!is_box) {
    throw UsageError(fmt::format(
        "--box={}: it must be six numbers X0,Y0,Z0,X1,Y1,Z1, the lower and the upper bound of each axis", flags.box));
  }
  return gs::Box{{ends[0], ends[1], ends[2]}, {ends[3], ends[4], ends[5]}};
}

// Bounding box of the means, for the error message of an empty box.
std::string ExtentText(const gs::SplatModel& model) {
  std::array<double, 6> ends;
  for (std::size_t k = 0; k < 3; ++k) {
    const float* means = model.attribute(splat::kMean + static_cast<int>(k));
    const auto [low, high] = std::minmax_element(means, means + model.count);
    ends[k] = static_cast<double>(*low) + model.origin[k], ends[3 + k] = static_cast<double>(*high) + model.origin[k];
  }
  return fmt::format("{:.6g}", fmt::join(ends, ","));
}

gs::SplatModel Cropped(const std::string& given, const gs::Box& box, gs::SplatModel model, std::string* message) {
  const std::vector<Index> within = gs::GaussiansWithin(model, box);
  if (within.empty()) {
    Fail(kBadArgument, "{}: no Gaussian is inside this box; their centres are in {}", FlagText("box", given),
         ExtentText(model));
  }
  *message += fmt::format("box: {} of {} Gaussians are inside\n", within.size(), model.count);
  return gs::InOrder(std::move(model), within);
}

gs::FloaterCount FloatersOf(const Flags& flags, const gs::SplatModel& model, RunFiles* files) {
  if (flags.scene.empty()) return gs::FindFloaters(model, nullptr);
  gs::LoadSceneOptions options;
  UseSceneFlags(flags, 0, &options);
  options.eps2d = model.eps2d, options.antialiased = model.antialiased;
  const gs::Scene scene = gs::LoadScene(flags.scene, options);
  files->ReadsScene(flags.scene, scene);
  files->Check();
  gs::SplatModel moved = model;
  gs::MoveToScene(scene, &moved);
  const gs::ScoringViews scoring_views = gs::TrainingViewsOf(scene, ToDouble(model.background));
  return gs::FindFloaters(moved, &scoring_views);
}

gs::SplatModel Cleaned(const Flags& flags, gs::SplatModel model, RunFiles* files, std::string* message) {
  const gs::FloaterCount found = FloatersOf(flags, model, files);
  if (found.kept.empty())
    Fail(kBadArgument, "--clean: all {} Gaussians would be removed; leave the flag out", model.count);
  *message += fmt::format(
      "clean: kept {} of {} Gaussians; removed {} too faint, {} that enclose the scene, {} without neighbours",
      found.kept.size(), model.count, found.faint, found.huge, found.isolated);
  *message += flags.scene.empty() ? "\n" : fmt::format(", {} that no photograph shows\n", found.under_observed);
  return gs::InOrder(std::move(model), found.kept);
}

}  // namespace

void CheckFilterFlags(const Flags& flags) {
  BoxOf(flags);
  if (!flags.clean && !flags.scene.empty()) throw UsageError("--scene needs --clean; give both");
  if (flags.scene.empty() && !SceneFlagTexts(flags).empty()) {
    throw UsageError(fmt::format("--{} needs --scene; give both", SceneFlagTexts(flags).front().first));
  }
}

gs::SplatModel Filtered(const Flags& flags, gs::SplatModel model, RunFiles* files, std::string* message) {
  if (const auto box = BoxOf(flags)) model = Cropped(flags.box, *box, std::move(model), message);
  if (flags.clean) model = Cleaned(flags, std::move(model), files, message);
  return model;
}

}  // namespace vesta::app
