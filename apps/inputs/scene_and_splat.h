// SPDX-License-Identifier: Apache-2.0
// The inputs of a command: the scene, by its folder and the flags that choose its photographs, and a splat with the
// scene that it shows.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::app {

// Sets the options by the flags that all commands with a SCENE take. memory_budget_gib: as MemoryOptions has it. Throws
// UsageError where flags exclude each other.
void UseSceneFlags(const Flags& flags, double memory_budget_gib, gs::LoadSceneOptions* options);

// As a checkpoint keeps them: names and values of those given. A file's path is absolute.
std::vector<std::pair<std::string, std::string>> SceneFlagTexts(const Flags& flags);
// Sets the flag, unless the command line has. False where there is no such flag or value.
bool RestoreSceneFlag(const std::string& name, const std::string& value, Flags* flags);

// Throws Error where there is no such folder.
void CheckSceneFolder(const std::string& path);

// How many views and points were loaded, and what is odd about them.
void PrintScene(const gs::Scene& scene);

// A splat and the scene it shows: what refine, eval and render start from.
struct PosedModel {
  gs::SplatModel model;  // in the frame of the scene; its background and eps2d are those to render with
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
