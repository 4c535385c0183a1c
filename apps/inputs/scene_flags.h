// SPDX-License-Identifier: Apache-2.0
// The scene that a command reads: its folder, and the flags that choose its photographs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/load_scene.h"

namespace vesta::app {

// Which photographs of a scene are read, and what for: the flags that all commands with a SCENE take.

// memory_budget_gib: as MemoryOptions has it. Throws UsageError where flags exclude each other.
void UseSceneFlags(const Flags& flags, double memory_budget_gib, gs::LoadSceneOptions* options);

// As a checkpoint keeps them: names and values of those given. A file's path is absolute.
std::vector<std::pair<std::string, std::string>> SceneFlagTexts(const Flags& flags);
// Sets the flag, unless the command line has. False where there is no such flag or value.
bool RestoreSceneFlag(const std::string& name, const std::string& value, Flags* flags);

// The folder of a scene, as commands take it and tell of it.

// Throws Error where there is no such folder.
void CheckSceneFolder(const std::string& path);

// How many views and points were loaded, and what is odd about them.
void PrintScene(const gs::Scene& scene);

}  // namespace vesta::app
