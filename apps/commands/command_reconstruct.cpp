// SPDX-License-Identifier: Apache-2.0
// reconstruct: makes a scene from photographs or a film, with the cameras that COLMAP finds.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <utility>

#include "apps/cli/child_process.h"
#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/reconstruct/camera_groups.h"
#include "apps/reconstruct/colmap_program.h"
#include "apps/reconstruct/colmap_stages.h"
#include "apps/reconstruct/film_frames.h"
#include "apps/reconstruct/folders.h"
#include "apps/reconstruct/largest_model.h"
#include "apps/reconstruct/photograph_source.h"
#include "apps/reconstruct/progress_file.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;
using Stage = ReconstructionStage;

constexpr std::string_view kStopsReconstruction =
    "\nstopping; the same command continues with the stage it stopped in\n";

// Before any work, so that an error leaves no files.
void CheckPrograms(const PhotographSource& source) {
  FindColmap();
  if (source.is_film) CheckFilmPrograms();
  if (std::ranges::any_of(source.names, IsHeic)) FindHeicConverter();
}

void CheckPlaces(const Flags& flags, const PhotographSource& source, const ReconstructionPaths& paths) {
  if (flags.frames && !source.is_film) {
    throw UsageError(fmt::format("--frames={}: has no effect on a folder of photographs; leave it out", *flags.frames));
  }
  const bool in_place = source.path == paths.images;
  const fs::path inside = fs::path(paths.scene).lexically_relative(source.path);
  if (!source.is_film && !inside.empty() && *inside.begin() != "..") {
    Fail(kBadArgument, "--out={}: inside the folder of the photographs, {}; choose another folder", flags.out,
         source.path);
  }
  if (in_place && std::ranges::any_of(source.names, IsHeic)) {
    Fail(kUnsupported, "{}: HEIC photographs are converted to JPEG into another folder; choose another --out",
         source.path);
  }
}

// COLMAP 3.8 takes 640 MiB per thread for the features of 1600 x 1200 pixels; the decoded photographs are added.
int ColmapThreads() {
  constexpr double kMibPerThread = 1024;
  return std::clamp(static_cast<int>(std::min(AvailableMemoryMib() / kMibPerThread, 1e6)), 1, NumThreads());
}

class Reconstruction {
 public:
  Reconstruction(const Flags& flags, PhotographSource source)
      : flags_(flags), source_(std::move(source)), paths_(flags.out), progress_(paths_, source_, flags.frames) {}

  void Run() {
    MakeFolder(paths_.work);
    progress_.Write();
    Collect();
    const ColmapProgram colmap(paths_.log, paths_.work, flags_.device, ColmapThreads());
    const std::vector<std::string> names = FindPhotographs(paths_.images).names;
    const GroupedPhotographs grouped = GroupByCamera(paths_.images, names);
    Do(Stage::kFeatures, fmt::format("features: {} photographs, {}", names.size(), CamerasOf(grouped)),
       [&] { ExtractFeatures(colmap, paths_, grouped); });
    const Pairs pairs = ChoosePairs(source_.is_film, names.size(), grouped.num_positions);
    Do(Stage::kMatches, fmt::format("matches: {}", TextOf(pairs)),
       [&] { MatchFeatures(colmap, paths_, pairs, names.size()); });
    Do(Stage::kMapping, "mapping: cameras and points", [&] { MapPhotographs(colmap, paths_, names.size()); });
    Report(WriteLargestModel(paths_), names.size());
  }

 private:
  // Runs the stage unless an earlier run has completed it.
  template <class Work>
  void Do(Stage stage, const std::string& title, const Work& work) {
    if (progress_.IsDone(stage)) {
      Print("{}; complete\n", title);
      return;
    }
    Print("{} ...\n", title);
    std::fflush(stdout);
    const double start = SecondsSinceStart();
    work();
    progress_.MarkDone(stage);
    Print("  done in {}\n", FormatDuration(SecondsSinceStart() - start));
    std::fflush(stdout);
  }

  void Collect() {
    const std::string others =
        source_.num_others > 0 ? fmt::format(" ({} other files are ignored)", source_.num_others) : "";
    const std::string title = source_.is_film ? fmt::format("photographs: frames of {}", OneLine(source_.path))
                                              : fmt::format("photographs: {}{}", source_.names.size(), others);
    Do(Stage::kPhotographs, title, [&] {
      if (progress_.photographs_are_in_place()) return;
      MakeEmptyFolder(paths_.collected);
      if (source_.is_film) {
        ExtractFrames(source_, flags_.frames, paths_.collected, paths_.work, paths_.log);
      } else {
        CollectPhotographs(source_, paths_.collected, paths_.work, paths_.log);
      }
    });
    // After MarkDone, so that an interrupted run knows SCENE/images as its own.
    if (FolderExists(paths_.collected)) Rename(paths_.collected, paths_.images);
  }

  static std::string CamerasOf(const GroupedPhotographs& grouped) {
    if (!grouped.groups[0].is_one_camera) return "cameras by COLMAP's rules";
    return grouped.groups.size() == 1 ? "1 camera" : fmt::format("{} cameras", grouped.groups.size());
  }

  static const char* TextOf(Pairs pairs) {
    if (pairs == Pairs::kAll) return "all pairs of photographs";
    return pairs == Pairs::kNeighbours ? "pairs of neighbouring photographs"
                                       : "pairs of photographs that are neighbours or have close GPS positions";
  }

  void Report(const ReconstructedScene& scene, std::size_t photographs) const {
    Print("registered {} of {} photographs; {} points with a mean reprojection error of {} pixels", scene.registered,
          photographs, scene.points, Figure(scene.error, 2));
    if (scene.models > 1) Print("; COLMAP found {} separate models, the largest is used", scene.models);
    Print("\n");
    if (scene.registered < photographs) {
      Print("{} photographs are left out: COLMAP could not connect them; more photographs between them help\n",
            photographs - scene.registered);
    }
    Print("wrote {}; next: vesta train {} --out=DIR\n", OneLine(flags_.out), OneLine(flags_.out));
  }

  const Flags& flags_;
  PhotographSource source_;
  ReconstructionPaths paths_;
  ProgressFile progress_;
};

}  // namespace

int RunReconstruct(const CommandLine& line) {
  const Flags& flags = line.flags;
  PhotographSource source = FindPhotographs(line.arguments[0]);
  CheckPlaces(flags, source, ReconstructionPaths(flags.out));
  CheckPrograms(source);
  RunFiles files;
  files.WritesInto(FlagText("out", flags.out), flags.out);
  files.Check();
  Reconstruction reconstruction(flags, std::move(source));
  OutputFolder out(flags.out);
  ::setenv("QT_QPA_PLATFORM", "offscreen", 0);  // COLMAP needs no display; a setting of the user stays
  CatchInterrupts(kStopsReconstruction);
  try {
    out.Keep();
    reconstruction.Run();
  } catch (const StoppedBySignal&) {
    return kInterruptedStatus;
  }
  return 0;
}

}  // namespace vesta::app
