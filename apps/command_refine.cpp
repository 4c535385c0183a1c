// refine and prune: from a splat and its scene to DIR/point_cloud.ply and DIR/metrics.json.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "apps/commands.h"
#include "apps/device.h"
#include "apps/posed_model.h"
#include "apps/print.h"
#include "apps/process.h"
#include "apps/train_and_write.h"
#include "kernels/core/check.h"
#include "kernels/core/process_memory.h"
#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/parsimony/prune.h"

namespace vesta::app {
namespace {

double ModelMib(const gs::SplatModel& model) {
  return static_cast<double>(model.data.size() * sizeof(float)) / (1 << 20);
}

// The part of the Gaussians that a .ply of so many MiB has room for.
double PartIn(double mib, const gs::SplatModel& model) {
  constexpr double kHeader = 4096;  // more than it takes, bytes
  const auto all = static_cast<double>(gs::SplatPlyBytes(model.count, model.sh_degree));
  return std::clamp((mib * (1 << 20) - kHeader) / all, 1 / static_cast<double>(model.count), 1.0);
}

void CheckOneGoal(const Flags& flags, const gs::TrainOptions& options) {
  const int given = (options.parsimony.prunes() ? 1 : 0) + (flags.max_loss ? 1 : 0) + (flags.size_mib ? 1 : 0);
  if (given == 1) return;
  throw UsageError(given == 0 ? "how much is to go? Give --keep=PART, under 1, --max_loss or --size_mib"
                              : "--keep, --max_loss and --size_mib: give only one of them");
}

// Takes out at once what the training would take out by and by, where there is none, or what the cost can spare.
// Returns a line on what went, if any did.
std::string PruneNow(const Flags& flags, const gs::TrainOptions& options, PosedModel& posed) {
  const bool by_and_by = options.adam.runs() && !flags.max_loss;
  if (by_and_by) return "";
  const Index before = posed.model.count;
  const double kept = std::round(options.parsimony.keep * static_cast<double>(before));
  gs::PruneOptions prune{.goal = {}, .criterion = options.parsimony.criterion, .seed = options.seed};
  if (flags.max_loss) {
    prune.goal.max_rise = flags.max_loss;
  } else {
    prune.goal.count = std::max<Index>(1, static_cast<Index>(kept));
  }
  gs::PruneResult result =
      gs::Prune(std::move(posed.model), gs::TrainingViewsOf(posed.scene, options.background), prune);
  posed.model = std::move(result.model);
  return fmt::format("pruned from {} to {} Gaussians in {} rounds; cost of the training views {:.3f} times what it was",
                     before, posed.model.count, result.rounds, result.cost_after / result.cost_before);
}

// Refines what `change` makes of the splat; it returns a line for the user, or none.
template <class Change>
int RefineChanged(const CommandLine& line, const Change& change) {
  const std::string& ply = line.arguments[0];
  const std::string& path = line.arguments[1];
  TrainSettings settings = SettingsOf(line);
  gs::TrainOptions& options = settings.options;
  CheckSceneFolder(path);
  RunFiles files = FilesOf(line);
  WritesResults(line.flags, line.flags.out, &files);
  files.Check();
  OutputFolder out(line.flags.out);
  PosedModel posed = LoadPosedModel(ply, path, line.flags.background, SceneOptions(options));
  files.ReadsScene(path, posed.scene);
  files.Check();
  options.background = ToDouble(posed.model.background);
  PrintScene(posed.scene);
  const double load_seconds = SecondsSinceStart();
  const std::string note = change(settings.options, posed);
  options.memory.before_mib = MemoryMib() - ModelMib(posed.model);
  const gs::StageRunners stages = StagesOf(line.flags.device);
  const ExpectedModel expected{posed.model.count, posed.model.count, posed.model.sh_degree};
  return TrainAndWrite(line.flags, posed.scene, settings, stages, expected, load_seconds, &out,
                       [&](const gs::TrainCallbacks& callbacks) {
                         gs::TrainResult result =
                             gs::Refine(posed.scene, std::move(posed.model), options, load_seconds, callbacks, stages);
                         if (!note.empty()) result.notes.push_back(note);
                         return result;
                       });
}

}  // namespace

int RunRefine(const CommandLine& line) {
  return RefineChanged(line, [](const gs::TrainOptions&, const PosedModel&) { return std::string(); });
}

int RunPrune(const CommandLine& line) {
  CheckOneGoal(line.flags, SettingsOf(line).options);
  return RefineChanged(line, [&](gs::TrainOptions& options, PosedModel& posed) {
    if (line.flags.size_mib) options.parsimony.keep = PartIn(*line.flags.size_mib, posed.model);
    return PruneNow(line.flags, options, posed);
  });
}

}  // namespace vesta::app
