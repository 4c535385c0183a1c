// bundle_adjust: a bundle adjustment problem, solved.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/bundle_on_gpu.h"
#include "apps/commands.h"
#include "apps/device.h"
#include "apps/interrupt.h"
#include "apps/outputs.h"
#include "apps/print.h"
#include "apps/process.h"
#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::app {
namespace {

using Cpu = CpuBackend<double>;

std::shared_ptr<const Loss> LossOf(const Flags& flags) {
  if (flags.loss == "huber") return std::make_shared<HuberLoss>(flags.loss_scale);
  if (flags.loss == "soft_l1") return std::make_shared<SoftLOneLoss>(flags.loss_scale);
  if (flags.loss == "cauchy") return std::make_shared<CauchyLoss>(flags.loss_scale);
  if (flags.loss == "arctan") return std::make_shared<ArctanLoss>(flags.loss_scale);
  if (flags.loss == "tukey") return std::make_shared<TukeyLoss>(flags.loss_scale);
  return nullptr;
}

void SetOptions(const Flags& flags, LmOptions& options) {
  if (flags.iterations) options.max_iterations = *flags.iterations;
  if (flags.pcg_iterations) options.normal_system.pcg.max_iterations = *flags.pcg_iterations;
  if (flags.time_limit > 0) options.max_seconds = std::max(0.0, flags.time_limit - SecondsSinceStart());
}

// A GPU is for plain least squares, and for who asks for it: auto is the CPU here until somebody has timed both.
bool SolvesOnGpu(const Flags& flags) {
  CheckDevice(flags.device);
  if (flags.device != Device::kCuda) return false;
  if (flags.loss != "none") Fail("--device=cuda: a GPU has no --loss={}; use --device=cpu or --loss=none", flags.loss);
  return true;
}

CallbackResult AfterIteration(const LmIteration& row, bool log) {
  if (log) {
    PrintText(stderr, fmt::format("{:4} cost {:.6e} lambda {:.1e} pcg {:4}{}\n", row.iteration, row.cost, row.lambda,
                                  row.pcg_iterations, row.accepted || row.iteration == 0 ? "" : " rejected"));
  }
  return Interrupted() ? CallbackResult::kStop : CallbackResult::kContinue;
}

// Root mean square over the observations of the distance to what was observed, pixels.
double RmsError(bundle::BundleProblem& problem, Cpu::ConstView x) {
  const Index observations = problem.structure().num_observations();
  return observations == 0 ? 0.0 : std::sqrt(problem.SquaredError(x) / static_cast<double>(observations));
}

nlohmann::ordered_json ToJson(const LmIteration& row) {
  return {{"iteration", row.iteration},           {"seconds", row.seconds},  {"cost", row.cost}, {"lambda", row.lambda},
          {"pcg_iterations", row.pcg_iterations}, {"accepted", row.accepted}};
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
                                 {"history", nlohmann::ordered_json::array()}};
  for (const LmIteration& row : summary.iterations) json["history"].push_back(ToJson(row));
  return json.dump(1) + "\n";
}

}  // namespace

int RunBundleAdjust(const CommandLine& line) {
  const Flags& flags = line.flags;
  const std::string& file = line.arguments[0];
  const bool on_gpu = SolvesOnGpu(flags);
  RunFiles files = FilesOf(line);
  files.Writes(Given("out", flags.out), flags.out);
  if (!flags.json.empty()) files.Writes(Given("json", flags.json), flags.json);
  files.Check();
  CheckWritable("out", flags.out);
  if (!flags.json.empty()) CheckWritable("json", flags.json);
  bundle::BundleData data = bundle::ReadBal(file);
  bundle::BundleProblem problem(data, {.loss = LossOf(flags)});
  const HostSpan<double> x(data.x.data(), static_cast<Index>(data.x.size()));
  const double rms_before = RmsError(problem, x);

  CatchInterrupts();
  // The result is about as long as what it comes from; its room is kept until it is there.
  AtomicFile out(flags.out);
  out.Reserve(static_cast<std::int64_t>(std::filesystem::file_size(file)));
  const auto set_options = [&](LmOptions& options) { SetOptions(flags, options); };
  const auto after_iteration = [&](const LmIteration& row) { return AfterIteration(row, flags.log_lm); };
  LmOptions options = bundle::BundleLmOptions();
  set_options(options);
  Cpu backend;
  const LmSummary summary = on_gpu ? SolveBundleOnGpu(data, set_options, after_iteration)
                                   : SolveLm<Cpu>(options, backend, problem, x, after_iteration);
  if (flags.log_lm) PrintText(stderr, fmt::format("{}", summary.FullReport()));
  if (summary.status == LmStatus::kNonFinite) {
    Fail("{}: {}; a point may lie in the plane of a camera that sees it", file, summary.message);
  }
  bundle::WriteBal(out, data);
  out.Commit();
  const double rms_after = RmsError(problem, x);
  if (!flags.json.empty()) {
    WriteFileAtomically(flags.json, ToJson(summary, data, rms_before, rms_after, on_gpu ? "cuda" : "cpu"));
  }
  Print("{} cameras, {} points, {} observations\n{}\n", data.num_cameras, data.num_points, data.observations.size(),
        summary.BriefReport());
  Print("reprojection error {:.4f} -> {:.4f} pixels (root mean square); wrote {}\n", rms_before, rms_after, flags.out);
  return Interrupted() ? kInterruptedStatus : 0;
}

}  // namespace vesta::app
