// SPDX-License-Identifier: Apache-2.0
#include "apps/inputs/scene_and_splat.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/process_memory.h"
#include "kernels/ranks/communicator.h"
#include "problems/gaussian_splatting/model/scene_frame.h"

namespace vesta::app {
namespace {

constexpr const char* kNames[] = {"images", "allow_missing", "test_every", "test_list"};

// Returns null if this is not a scene flag.
const schema::Field<Flags>* FindSceneFlag(const std::string& name) {
  if (std::ranges::find(kNames, name) == std::end(kNames)) return nullptr;
  for (const FlagRow& row : ProgramFlags()) {
    if (row.field.name == name) return &row.field;
  }
  return nullptr;
}

bool IsGiven(const schema::Field<Flags>& flag, const Flags& flags) { return flag.Text(flags) != flag.Text(Flags()); }

// Bytes for decoded photographs: --photographs_mib, or half of the program's memory.
double PhotographsBytes(const Flags& flags, double memory_budget_gib) {
  constexpr double kMib = 1 << 20, kMibInGib = 1024, kPart = 0.5;
  if (flags.photographs_mib) return *flags.photographs_mib * kMib;
  const double available = AvailableMemoryMib() / NumRanksOnThisMachine(), budget = memory_budget_gib * kMibInGib;
  return kPart * kMib * (budget > 0 ? std::min(available, budget) : available);
}

}  // namespace

void UseSceneFlags(const Flags& flags, double memory_budget_gib, gs::LoadSceneOptions* options) {
  if (flags.test_every && !flags.test_list.empty()) {
    throw UsageError("--test_every and --test_list: give only one of them");
  }
  options->image_folder = flags.images;
  options->allow_missing = flags.allow_missing;
  options->photographs_bytes = PhotographsBytes(flags, memory_budget_gib);
  options->test_views = {.every = flags.test_every, .list = flags.test_list};
}

std::vector<std::pair<std::string, std::string>> SceneFlagTexts(const Flags& flags) {
  Flags elsewhere = flags;
  if (!flags.test_list.empty()) elsewhere.test_list = std::filesystem::absolute(flags.test_list).string();
  std::vector<std::pair<std::string, std::string>> texts;
  for (const char* name : kNames) {
    const schema::Field<Flags>* flag = FindSceneFlag(name);
    if (IsGiven(*flag, elsewhere)) texts.emplace_back(name, flag->Text(elsewhere));
  }
  return texts;
}

bool RestoreSceneFlag(const std::string& name, const std::string& value, Flags* flags) {
  const schema::Field<Flags>* flag = FindSceneFlag(name);
  if (!flag) return false;
  Flags scratch;
  if (!flag->Set(value, scratch)) return false;
  return IsGiven(*flag, *flags) || flag->Set(value, *flags);
}

void PrintLines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) Print("{}\n", line);
}

void CheckSceneFolder(const std::string& path) {
  if (FolderExists(path)) return;
  if (FileExists(path))
    Fail(kNotFound, "{}: this is a file, but a scene folder is expected; `vesta help` shows the order of arguments",
         path);
  Fail(kNotFound, "{}: no such scene folder", path);
}

void PrintScene(const gs::Scene& scene) {
  const auto count = [&](gs::ViewRole role) {
    return std::ranges::count_if(scene.views, [&](const gs::View& view) { return view.role == role; });
  };
  const auto held_out = count(gs::ViewRole::kHeldOut);
  Print("{} training views, {}{} test views ({}); {} points; loaded in {:.1f} s\n", count(gs::ViewRole::kTraining),
        held_out > 0 ? fmt::format("{} held out, ", held_out) : "", count(gs::ViewRole::kTest), scene.split,
        scene.points.size(), SecondsSinceStart());
  PrintLines(scene.notes);
  std::fflush(stdout);
}

gs::SplatModel LoadSplat(const std::string& path) {
  std::vector<std::string> notes;
  gs::SplatModel model = gs::ReadSplat(path, &notes);
  PrintLines(notes);
  return model;
}

void UseRenderingFlags(const Flags& flags, gs::SplatModel* model) {
  if (flags.background) model->background = ToFloat(*flags.background);
  if (flags.eps2d) model->eps2d = *flags.eps2d;
  if (flags.antialias) model->antialiased = *flags.antialias;
}

void UseSplatRendering(const gs::SplatModel& model, gs::LoadSceneOptions* options) {
  options->background = model.background, options->eps2d = model.eps2d, options->antialiased = model.antialiased;
}

gs::Scene LoadSceneOfSplat(const std::string& path, const gs::LoadSceneOptions& options) {
  gs::Scene scene = gs::LoadScene(path, options);
  std::erase(scene.notes, scene.points_note);
  return scene;
}

PosedModel LoadPosedModel(const std::string& splat, const std::string& scene, const Flags& flags,
                          gs::LoadSceneOptions options) {
  PosedModel posed;
  posed.model = LoadSplat(splat);
  UseRenderingFlags(flags, &posed.model);
  UseSplatRendering(posed.model, &options);
  posed.scene = LoadSceneOfSplat(scene, options);
  gs::MoveToScene(posed.scene, &posed.model);
  return posed;
}

PosedModel LoadPosedModel(const CommandLine& line) {
  gs::LoadSceneOptions options;
  options.may_lack_training = true;
  options.downscale = line.flags.downscale;
  UseSceneFlags(line.flags, 0, &options);
  PosedModel posed = LoadPosedModel(line.arguments[0], line.arguments[1], line.flags, options);
  PrintLines(posed.scene.notes);
  return posed;
}

std::array<double, 3> ToDouble(const std::array<float, 3>& color) {
  return {static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2])};
}

std::array<float, 3> ToFloat(const std::array<double, 3>& color) {
  return {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
}

}  // namespace vesta::app
