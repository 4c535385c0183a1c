// refine and prune: from a splat and its scene to DIR/point_cloud.ply and DIR/metrics.json.
#include <fmt/format.h>

#include <algorithm>
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

// What of --keep, --max_loss and --size_mib was given, of such a model.
gs::PruneGoal GoalOf(const Flags& flags, const gs::SplatModel& model) {
  if (flags.max_loss) return {.count = {}, .max_rise = flags.max_loss};
  const auto gaussians = static_cast<double>(model.count);
  double count = flags.keep.value_or(1) * gaussians;
  if (flags.size_mib) {
    constexpr double kHeader = 4096;  // more than it takes
    const auto each = static_cast<double>(gs::SplatPlyBytes(model.count, model.sh_degree)) / gaussians;
    count = (*flags.size_mib * (1 << 20) - kHeader) / each;
  }
  return {.count = std::max<Index>(1, static_cast<Index>(std::min(count, gaussians))), .max_rise = {}};
}

void CheckOneGoal(const Flags& flags) {
  const int given = (flags.keep ? 1 : 0) + (flags.max_loss ? 1 : 0) + (flags.size_mib ? 1 : 0);
  if (given == 1) return;
  throw UsageError(given == 0 ? "how much is to go? Give one of --keep, --max_loss and --size_mib"
                              : "--keep, --max_loss and --size_mib: give only one of them");
}

// A line on what went.
std::string Report(const gs::PruneResult& result, Index before) {
  std::string line =
      fmt::format("pruned from {} to {} Gaussians in {} rounds; cost of the training views {:.3f} times what it was",
                  before, result.model.count, result.rounds, result.cost_after / result.cost_before);
  if (result.unsupported > 0) {
    line += fmt::format("; {} of those that went hardly any training view shows", result.unsupported);
  }
  return line;
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
  const std::string note = change(posed, options);
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
  return RefineChanged(line, [](const PosedModel&, const gs::TrainOptions&) { return std::string(); });
}

int RunPrune(const CommandLine& line) {
  CheckOneGoal(line.flags);
  return RefineChanged(line, [&](PosedModel& posed, const gs::TrainOptions& options) {
    const Index before = posed.model.count;
    const gs::PruneGoal goal = GoalOf(line.flags, posed.model);
    gs::PruneResult result = gs::Prune(std::move(posed.model), gs::TrainingViewsOf(posed.scene, options.background),
                                       {.goal = goal, .criterion = line.flags.criterion, .seed = options.seed});
    posed.model = std::move(result.model);
    return Report(result, before);
  });
}

}  // namespace vesta::app
