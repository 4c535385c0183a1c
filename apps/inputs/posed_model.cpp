// SPDX-License-Identifier: Apache-2.0
#include "apps/inputs/posed_model.h"

#include <fmt/format.h>

#include "apps/inputs/scene_flags.h"
#include "problems/gaussian_splatting/model/scene_frame.h"

namespace vesta::app {

void UseRenderingFlags(const Flags& flags, gs::SplatModel* model) {
  if (flags.background) model->background = ToFloat(*flags.background);
  if (flags.low_pass) model->low_pass = *flags.low_pass;
}

void LoadFor(const gs::SplatModel& model, gs::LoadSceneOptions* options) {
  options->background = model.background, options->low_pass = model.low_pass;
}

PosedModel LoadPosedModel(const std::string& splat, const std::string& scene, const Flags& flags,
                          gs::LoadSceneOptions options) {
  PosedModel posed;
  posed.model = gs::ReadSplat(splat);
  UseRenderingFlags(flags, &posed.model);
  LoadFor(posed.model, &options);
  posed.scene = gs::LoadScene(scene, options);
  gs::MoveToScene(posed.scene, &posed.model);
  return posed;
}

PosedModel LoadPosedModel(const CommandLine& line) {
  gs::LoadSceneOptions options;
  options.downscale = line.flags.downscale;
  UseSceneFlags(line.flags, 0, &options);
  return LoadPosedModel(line.arguments[0], line.arguments[1], line.flags, options);
}

std::array<double, 3> ToDouble(const std::array<float, 3>& color) {
  return {static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2])};
}

std::array<float, 3> ToFloat(const std::array<double, 3>& color) {
  return {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
}

}  // namespace vesta::app
