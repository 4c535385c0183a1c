// SPDX-License-Identifier: Apache-2.0
// bundle_adjust: reads a BAL problem, solves it, and writes the result.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/commands/least_squares.h"
#include "apps/device/bundle_on_gpu.h"
#include "apps/device/device.h"
#include "apps/device/ranks.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/bundle_parts.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::app {
namespace {

using Cpu = CpuBackend<double>;

// The GPU solves only problems without a robust loss, and only for --device=cuda: auto is the CPU here, because no
// times of both were compared.
bool SolvesOnGpu(const Flags& flags) {
  CheckDevice(flags.device);
  if (flags.device != Device::kCuda) return false;
  if (flags.loss != "none")
    Fail(kUnsupported, "--device=cuda: --loss={} is not available on a GPU; use --device=cpu or --loss=none",
         flags.loss);
  return true;
}

// Root mean square of the reprojection errors over the observations, in pixels.
double RmsError(double squared_error, const bundle::BundleData& data) {
  const auto observations = static_cast<double>(data.observations.size());
  return data.observations.empty() ? 0.0 : std::sqrt(squared_error / observations);
}

std::string ToJson(const LmSummary& summary, const bundle::BundleData& data, double rms_before, double rms_after,
                   const char* device) {
  nlohmann::ordered_json json = {{"cameras", data.num_cameras},
                                 {"points", data.num_points},
                                 {"observations", data.observations.size()},
                                 {"status", ToString(summary.status)},
                                 {"initial_cost", summary.initial_cost},
                                 {"final_cost", summary.final_cost},
                                 {"initial_rms_pixels", rms_before},
                                 {"final_rms_pixels", rms_after},
                                 {"seconds", summary.total_seconds},
                                 {"peak_memory_mib", PeakMemoryMib()},
                                 {"device", device},
                                 {"threads", NumThreads()},
                                 {"history", HistoryOf(summary)}};
  return json.dump(1) + "\n";
}

// The result of a solve, besides data.x.
struct Adjusted {
  LmSummary summary;
  double rms_before = 0, rms_after = 0;
};

Adjusted SolveAlone(const bundle::BundleProblemOptions& problem_options, const LmOptions& options,
                    bundle::BundleData& data, const LmCallback& callback) {
  bundle::BundleProblem problem(data, problem_options);
  const HostSpan<double> x(data.x.data(), static_cast<Index>(data.x.size()));
  const double before = RmsError(problem.SquaredError(x), data);
  Cpu backend;
  const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x, callback);
  return {summary, before, RmsError(problem.SquaredError(x), data)};
}

// Each rank optimises its own points; all ranks optimise the cameras together. At the end data.x is the same on all
// ranks.
Adjusted SolveOverRanks(const bundle::BundleProblemOptions& problem_options, const LmOptions& options,
                        bundle::BundleData& data, const LmCallback& callback) {
  constexpr int kParts = 64;
  bundle::BundleParts parts(data, kParts, problem_options);
  DistributedProblem<Cpu> problem(WorldCommunicator(), parts);
  const HostSpan<double> x(data.x.data(), static_cast<Index>(data.x.size()));
  const auto rms_error = [&] {
    std::vector<double> mine;
    for (OwnPart<Cpu>& part : problem.own()) {
      mine.push_back(static_cast<bundle::BundleProblem&>(*part.owned).SquaredError(problem.Localize(x, part)));
    }
    return RmsError(problem.SumNumbers(mine), data);
  };
  const double before = rms_error();
  Cpu backend;
  const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x, callback);
  return {summary, before, rms_error()};
}

// Solves on the GPU; the reprojection errors are computed on the CPU.
Adjusted SolveOnGpu(const Flags& flags, bundle::BundleData& data, const LmCallback& callback) {
  bundle::BundleProblem problem(data);
  const HostSpan<double> x(data.x.data(), static_cast<Index>(data.x.size()));
  const double before = RmsError(problem.SquaredError(x), data);
  const LmSummary summary = SolveBundleOnGpu(
      data, [&](LmOptions& options) { SetLimits(flags, options); }, callback);
  return {summary, before, RmsError(problem.SquaredError(x), data)};
}

// For rank 0.
void WriteAdjusted(const Flags& flags, const Adjusted& adjusted, const bundle::BundleData& data, AtomicFile& out,
                   bool on_gpu) {
  bundle::WriteBal(out, data);
  out.Commit();
  if (!flags.json.empty())
    WriteFileAtomically(
        flags.json, ToJson(adjusted.summary, data, adjusted.rms_before, adjusted.rms_after, on_gpu ? "cuda" : "cpu"));
  Print("{} cameras, {} points, {} observations\n{}\n", data.num_cameras, data.num_points, data.observations.size(),
        adjusted.summary.BriefReport());
  Print("reprojection error {:.4f} -> {:.4f} pixels (root mean square); wrote {}\n", adjusted.rms_before,
        adjusted.rms_after, flags.out);
}

}  // namespace

int RunBundleAdjust(const CommandLine& line) {
  const Flags& flags = line.flags;
  const std::string& file = line.arguments[0];
  const bundle::BundleProblemOptions problem_options{.loss = LossOf(flags)};
  const bool on_gpu = SolvesOnGpu(flags), over_ranks = IsStartedInRanks() && !on_gpu;
  if (on_gpu && NumStartedRanks() > 1)
    Fail(kUnsupported, "--device=cuda: several processes solve on CPUs only; use --device=cpu");
  bundle::BundleData data = FirstRankFirst([&] {
    if (IsFirstRank()) CheckOutputs(line);
    return bundle::ReadBal(file);
  });
  CatchInterrupts();
  std::optional<AtomicFile> out;
  if (IsFirstRank()) {
    // The result is about as long as the input. Its disk space is reserved before the solve.
    out.emplace(flags.out);
    out->Reserve(static_cast<std::int64_t>(std::filesystem::file_size(file)));
  }
  const bool logs = flags.log_lm && IsFirstRank();
  const auto after_iteration = [&](const LmIteration& row) { return AfterIteration(row, logs); };
  LmOptions options = bundle::BundleLmOptions();
  SetLimits(flags, options);
  const Adjusted adjusted = on_gpu       ? SolveOnGpu(flags, data, after_iteration)
                            : over_ranks ? SolveOverRanks(problem_options, options, data, after_iteration)
                                         : SolveAlone(problem_options, options, data, after_iteration);
  if (logs) PrintText(stderr, fmt::format("{}", adjusted.summary.FullReport()));
  if (adjusted.summary.status == LmStatus::kNonFinite) {
    Fail(kBadFile, "{}: {}; perhaps a point lies in the plane of a camera that observes it", file,
         adjusted.summary.message);
  }
  if (out) WriteAdjusted(flags, adjusted, data, *out, on_gpu);
  return Interrupted() ? kInterruptedStatus : 0;
}

}  // namespace vesta::app
