// SPDX-License-Identifier: Apache-2.0
// The `vesta` program: reconstruct | train | refine | prune | eval | render | view | convert | doctor | report | config
// | bundle_adjust | pose_graph | help.
#include <glog/logging.h>

#include <csignal>
#include <cstdio>
#include <new>
#include <optional>
#include <string>

#include "apps/cli/flags.h"
#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/device/device.h"
#include "apps/device/ranks.h"
#include "apps/settings/train_settings.h"
#include "apps/usage/help.h"
#include "apps/usage/parse_command_line.h"
#include "kernels/core/check.h"
#include "kernels/core/process_memory.h"
#include "kernels/core/profile.h"

namespace vesta::app {
namespace {

constexpr int kFailed = 1, kUsage = 2;  // exit statuses

// The other commands would repeat all their work in each process; Run refuses that.
bool MayRunInRanks(Command command) {
  return command == kTrain || command == kRefine || command == kPrune || command == kBundleAdjust;
}

int RunCommand(const CommandLine& line) {
  switch (line.command->command) {
    case kReconstruct:
      return RunReconstruct(line);
    case kTrain:
      return RunTrain(line);
    case kRefine:
      return RunRefine(line);
    case kPrune:
      return RunPrune(line);
    case kEval:
      return RunEval(line);
    case kRender:
      return RunRender(line);
    case kConvert:
      return RunConvert(line);
    case kView:
      return RunView(line);
    case kDoctor:
      return RunDoctor(line);
    case kReport:
      return RunReport(line);
    case kConfig:
      return RunConfig(line);
    case kBundleAdjust:
      return RunBundleAdjust(line);
    case kPoseGraph:
      return RunPoseGraph(line);
  }
  return kUsage;
}

int Run(int argc, char** argv) {
  const CommandLine line = ParseCommandLine({argv + 1, argv + argc});
  if (!line.command) {
    Print("{}", HelpText(line.arguments));
    return 0;
  }
  if (line.flags.quiet || (MayRunInRanks(line.command->command) && !IsFirstRank())) DiscardStdout();
  UseComputeFlags(line.flags);
  if (NumStartedRanks() > 1 && !MayRunInRanks(line.command->command)) {
    Fail(kUnsupported, "vesta {} runs in one process; start it without mpirun", line.command->name);
  }
  std::optional<Profile> profile;  // on rank 0
  if (line.flags.profile && IsFirstRank()) profile.emplace(ProfileClock(line.flags.device));
  const ProfileScope timed(profile ? &*profile : nullptr);
  const int status = RunCommand(line);
  if (profile) Print("{}", ProfileTable(profile->Rows()));
  return status;
}

int Complain(const char* message, int status) {
  const std::string line = OneLine(message);
  if (!IsReportedByOtherRank(line)) PrintText(stderr, fmt::format("vesta: {}{}\n", RankPrefix(), line));
  AbortOtherRanks(line, status);
  return status;
}

}  // namespace
}  // namespace vesta::app

int main(int argc, char** argv) {
  namespace app = vesta::app;
  app::SecondsSinceStart();
  std::signal(SIGXFSZ, SIG_IGN);  // a file-size limit is then a write error
  vesta::ReturnFreedMemoryToSystem();
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  try {
    const int status = app::Run(argc, argv);
    app::WaitForOtherRanks();
    const std::string error = app::PrintError();
    return error.empty() || status != 0 ? status : app::Complain(error.c_str(), app::kFailed);
  } catch (const vesta::OtherRankFailed& error) {
    app::AbortOtherRanks(error.what(), app::kFailed);  // the other rank has printed the reason
    return app::kFailed;
  } catch (const app::UsageError& error) {
    return app::Complain(error.what(), app::kUsage);
  } catch (const std::bad_alloc&) {
    return app::Complain("out of memory; use a larger --downscale, fewer Gaussians, or a smaller problem",
                         app::kFailed);
  } catch (const std::exception& error) {
    return app::Complain(error.what(), app::kFailed);
  }
}
