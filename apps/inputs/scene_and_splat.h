// SPDX-License-Identifier: Apache-2.0
// The inputs of a command: a scene, with the flags that select its photographs, and a splat with its scene.
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

// Sets the options from the flags that all commands with a SCENE accept. memory_budget_gib: as in MemoryOptions. Throws
// UsageError if flags exclude each other.
void UseSceneFlags(const Flags& flags, double memory_budget_gib, gs::LoadSceneOptions* options);

// Names and values of the scene flags that were given, as a checkpoint stores them. Paths of files are absolute.
std::vector<std::pair<std::string, std::string>> SceneFlagTexts(const Flags& flags);
// Sets the flag unless the command line gave it. Returns false if there is no such flag or the value is invalid.
bool RestoreSceneFlag(const std::string& name, const std::string& value, Flags* flags);

// Throws Error if the folder does not exist.
void CheckSceneFolder(const std::string& path);

// Prints the numbers of views and points, and the notes of loading.
void PrintScene(const gs::Scene& scene);

// A splat and the scene it shows: the inputs of refine, prune, eval and render.
struct PosedModel {
  gs::SplatModel model;  // in the frame of the scene; rendered with its own background and eps2d
  gs::Scene scene;
};

// Replaces the background and eps2d of the splat by --background and --eps2d, if given.
void UseRenderingFlags(const Flags& flags, gs::SplatModel* model);
// Loads the scene with the background and eps2d of the splat.
void UseSplatRendering(const gs::SplatModel& model, gs::LoadSceneOptions* options);
// Reads both. The background and eps2d come from the flags or the splat, not from `options`.
PosedModel LoadPosedModel(const std::string& splat, const std::string& scene, const Flags& flags,
                          gs::LoadSceneOptions options);
// Reads the SPLAT and SCENE of eval, render or view.
PosedModel LoadPosedModel(const CommandLine& line);

std::array<double, 3> ToDouble(const std::array<float, 3>& color);
std::array<float, 3> ToFloat(const std::array<double, 3>& color);

}  // namespace vesta::app
