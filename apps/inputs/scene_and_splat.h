// SPDX-License-Identifier: Apache-2.0
// Loads the inputs of the commands: a splat, and a scene with the flags that select its photographs (scene flags).
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

// Sets the loading options from the scene flags, which all commands with a SCENE accept. memory_budget_gib: as in
// MemoryOptions. Throws UsageError if flags exclude each other.
void UseSceneFlags(const Flags& flags, double memory_budget_gib, gs::LoadSceneOptions* options);

// Names and values of the given scene flags, for a checkpoint. Paths are absolute.
std::vector<std::pair<std::string, std::string>> SceneFlagTexts(const Flags& flags);
// Sets a scene flag from a checkpoint, unless the command line has set it. Returns false if there is no such flag or
// the value is invalid.
bool RestoreSceneFlag(const std::string& name, const std::string& value, Flags* flags);

void PrintLines(const std::vector<std::string>& lines);

// Throws Error if the folder does not exist.
void CheckSceneFolder(const std::string& path);

// Prints the numbers of views and points, and Scene::notes.
void PrintScene(const gs::Scene& scene);

// The inputs of refine, prune, eval and render.
struct PosedModel {
  gs::SplatModel model;  // in the scene's frame; keeps its background, eps2d and antialiasing
  gs::Scene scene;
};

// Reads a splat and prints notes.
gs::SplatModel LoadSplat(const std::string& path);
// Replaces the background, eps2d and antialiasing of the splat by --background, --eps2d and --antialias, if given.
void UseRenderingFlags(const Flags& flags, gs::SplatModel* model);
// Copies the background, eps2d and antialiasing of the splat to the options for loading the scene.
void UseSplatRendering(const gs::SplatModel& model, gs::LoadSceneOptions* options);
// Loads the scene of a given splat, without the note about random points, which are not used.
gs::Scene LoadSceneOfSplat(const std::string& path, const gs::LoadSceneOptions& options);
// Reads the files. UseRenderingFlags changes the splat, whose background, eps2d and antialiasing replace those in
// `options`.
PosedModel LoadPosedModel(const std::string& splat, const std::string& scene, const Flags& flags,
                          gs::LoadSceneOptions options);
// For the arguments SPLAT and SCENE of eval, render or view. Prints Scene::notes.
PosedModel LoadPosedModel(const CommandLine& line);

std::array<double, 3> ToDouble(const std::array<float, 3>& color);
std::array<float, 3> ToFloat(const std::array<double, 3>& color);

}  // namespace vesta::app
