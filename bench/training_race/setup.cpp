#include "bench/training_race/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/command_line.h"
#include "apps/flags.h"
#include "apps/posed_model.h"
#include "apps/train_flags.h"
#include "bench/training_race/curve.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::bench {
namespace {

// As `vesta train SCENE FLAGS` takes them.
gs::TrainOptions OptionsOf(const std::string& scene, const std::vector<std::string>& flags) {
  // --out: train insists on one.
  std::vector<std::string> words = {"vesta", "train", scene, "--out=."};
  words.insert(words.end(), flags.begin(), flags.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  app::ParseCommandLine(static_cast<int>(words.size()), argv.data());
  gs::TrainOptions options = app::WithTrainFlags(gs::PresetOptions(FLAGS_preset));
  options.background = app::ToDouble(app::BackgroundFromFlag());
  return options;
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
  if (setup.arguments.positional.size() != 1) Fail("the form is: SCENE [flags] [-- flags of vesta train]");
  const std::string& path = setup.arguments.positional[0];
  setup.options = OptionsOf(path, {dashes == end ? end : dashes + 1, end});
  app::UseComputeFlags();
  setup.threads = NumThreads();
  SetNumThreads(1);
  setup.scene_name = NameOf(path);
  if (FLAGS_downscale > 1) setup.scene_name += fmt::format("/{}", FLAGS_downscale);
  setup.scene = app::LoadSceneOver(path, app::BackgroundFromFlag());
  return setup;
}

std::ofstream OpenCurves(const Arguments& arguments) {
  const std::string path = arguments.Flag("curves", "");
  std::ofstream curves;
  if (path.empty()) return curves;
  curves.open(path);
  if (!curves) Fail("--curves={}: the file cannot be written", path);
  WriteCsvHeader(curves);
  return curves;
}

int ReportErrors(const char* bench, int (*body)(int, char**), int argc, char** argv) {
  try {
    return body(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", bench, error.what());
    return 1;
  }
}

}  // namespace vesta::bench
