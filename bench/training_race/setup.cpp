// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/cli/flags.h"
#include "apps/settings/train_settings.h"
#include "apps/usage/parse_command_line.h"
#include "bench/training_race/curve.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "splatting/train/settings/training_plan.h"

namespace vesta::bench {
namespace {

// Parses `vesta train SCENE FLAGS`.
app::CommandLine CommandLineOf(const std::string& scene, const std::vector<std::string>& flags) {
  // train requires --out.
  std::vector<std::string> words = {"train", scene, "--out=."};
  words.insert(words.end(), flags.begin(), flags.end());
  return app::ParseCommandLine(words);
}

std::string NameOf(const std::string& scene) {
  const std::filesystem::path path(scene);
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace

RaceSetup SetUpRace(int argc, char** argv, const std::vector<std::string>& known) {
  char** const end = argv + argc;
  char** const dashes = std::find_if(argv, end, [](const char* word) { return std::string(word) == "--"; });
  RaceSetup setup{Arguments(static_cast<int>(dashes - argv), argv, known), {}, {}, {}, 0};
  if (setup.arguments.positional.size() != 1) Fail(kBadArgument, "usage: SCENE [flags] [-- flags of vesta train]");
  const std::string& path = setup.arguments.positional[0];
  const app::CommandLine line = CommandLineOf(path, {dashes == end ? end : dashes + 1, end});
  setup.options = app::SettingsOf(line).options;
  app::UseComputeFlags(line.flags);
  setup.threads = NumThreads();
  SetNumThreads(1);
  setup.scene_name = NameOf(path);
  if (setup.options.downscale > 1) setup.scene_name += fmt::format("/{}", setup.options.downscale);
  setup.scene = gs::LoadScene(path, app::SceneOptions(line.flags, setup.options));
  setup.options = gs::FitToScene(setup.options, gs::NumTrainingViews(setup.scene));
  // For benchmarks of LM, the LM stage must not be empty.
  constexpr int kLmIterations = 8;
  if (setup.options.lm.iterations == 0) setup.options.lm.iterations = kLmIterations;
  return setup;
}

std::ofstream OpenCurves(const Arguments& arguments) {
  const std::string path = arguments.Flag("curves", "");
  std::ofstream curves;
  if (path.empty()) return curves;
  curves.open(path);
  if (!curves) Fail(kCannotWrite, "--curves={}: the file cannot be written", path);
  WriteCsvHeader(curves);
  return curves;
}

}  // namespace vesta::bench
