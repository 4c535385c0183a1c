// SPDX-License-Identifier: Apache-2.0
// A splat and the scene it shows: what refine, eval and render start from.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::app {

struct PosedModel {
  gs::SplatModel model;  // in the frame of the scene; its background and low_pass are those to render with
  gs::Scene scene;
};

// The flags' background and low-pass filter, where they are given, in place of what the splat states.
void UseRenderingFlags(const Flags& flags, gs::SplatModel* model);
// Has a scene loaded for what the splat is rendered with.
void LoadFor(const gs::SplatModel& model, gs::LoadSceneOptions* options);
// Reads both, the scene as told but for what the splat states, or the flags do.
PosedModel LoadPosedModel(const std::string& splat, const std::string& scene, const Flags& flags,
                          gs::LoadSceneOptions options);
// Those that eval or render name.
PosedModel LoadPosedModel(const CommandLine& line);

std::array<double, 3> ToDouble(const std::array<float, 3>& color);
std::array<float, 3> ToFloat(const std::array<double, 3>& color);

}  // namespace vesta::app
