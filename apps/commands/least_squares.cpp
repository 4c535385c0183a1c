// SPDX-License-Identifier: Apache-2.0
#include "apps/commands/least_squares.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/cli/process.h"

namespace vesta::app {

std::shared_ptr<const Loss> LossOf(const Flags& flags) {
  if (flags.loss == "none" && flags.loss_scale != Flags().loss_scale) {
    throw UsageError(fmt::format("--loss_scale={}: has no effect without --loss; choose one, for example --loss=huber",
                                 flags.loss_scale));
  }
  if (flags.loss == "huber") return std::make_shared<HuberLoss>(flags.loss_scale);
  if (flags.loss == "soft_l1") return std::make_shared<SoftLOneLoss>(flags.loss_scale);
  if (flags.loss == "cauchy") return std::make_shared<CauchyLoss>(flags.loss_scale);
  if (flags.loss == "arctan") return std::make_shared<ArctanLoss>(flags.loss_scale);
  if (flags.loss == "tukey") return std::make_shared<TukeyLoss>(flags.loss_scale);
  return nullptr;
}

void CheckOutputs(const CommandLine& line) {
  const Flags& flags = line.flags;
  RunFiles files = FilesOf(line);
  files.Writes(FlagText("out", flags.out), flags.out);
  if (!flags.json.empty()) files.Writes(FlagText("json", flags.json), flags.json);
  files.Check();
  CheckWritable("out", flags.out);
  if (!flags.json.empty()) CheckWritable("json", flags.json);
}

void SetLimits(const Flags& flags, LmOptions& options) {
  if (flags.iterations) options.max_iterations = *flags.iterations;
  if (flags.pcg_iterations) options.normal_system.pcg.max_iterations = *flags.pcg_iterations;
  if (flags.time_limit > 0) options.max_seconds = std::max(1e-3, flags.time_limit - SecondsSinceStart());
}

CallbackResult AfterIteration(const LmIteration& row, bool log) {
  if (log) {
    PrintText(stderr, fmt::format("{:4} cost {:.6e} lambda {:.1e} pcg {:4}{}\n", row.iteration, row.cost, row.lambda,
                                  row.pcg_iterations, row.accepted || row.iteration == 0 ? "" : " rejected"));
  }
  return Interrupted() ? CallbackResult::kStop : CallbackResult::kContinue;
}

nlohmann::ordered_json HistoryOf(const LmSummary& summary) {
  nlohmann::ordered_json history = nlohmann::ordered_json::array();
  for (const LmIteration& row : summary.iterations) {
    history.push_back({{"iteration", row.iteration},
                       {"seconds", row.seconds},
                       {"cost", row.cost},
                       {"lambda", row.lambda},
                       {"pcg_iterations", row.pcg_iterations},
                       {"accepted", row.accepted}});
  }
  return history;
}

}  // namespace vesta::app
