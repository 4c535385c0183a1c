// bundle_adjust: a bundle adjustment problem, solved.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/bundle_on_gpu.h"
#include "apps/commands.h"
#include "apps/device.h"
#include "apps/flags.h"
#include "apps/interrupt.h"
#include "apps/output_folder.h"
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

std::shared_ptr<const Loss> LossOfFlags() {
  if (FLAGS_loss == "huber") return std::make_shared<HuberLoss>(FLAGS_loss_scale);
  if (FLAGS_loss == "soft_l1") return std::make_shared<SoftLOneLoss>(FLAGS_loss_scale);
  if (FLAGS_loss == "cauchy") return std::make_shared<CauchyLoss>(FLAGS_loss_scale);
  if (FLAGS_loss == "arctan") return std::make_shared<ArctanLoss>(FLAGS_loss_scale);
  if (FLAGS_loss == "tukey") return std::make_shared<TukeyLoss>(FLAGS_loss_scale);
  return nullptr;
}

void SetOptionsOfFlags(LmOptions& options) {
  if (IsSet("iterations")) options.max_iterations = FLAGS_iterations;
  if (IsSet("pcg_iterations")) options.normal_system.pcg.max_iterations = FLAGS_pcg_iterations;
  if (FLAGS_time_limit > 0) options.max_seconds = std::max(0.0, FLAGS_time_limit - SecondsSinceStart());
}

// A GPU is for plain least squares, and for who asks for it: auto is the CPU here until somebody has timed both.
bool SolvesOnGpu() {
  CheckDeviceFlag();
  if (FLAGS_device != "cuda") return false;
  if (FLAGS_loss != "none") Fail("--device=cuda: a GPU has no --loss={}; use --device=cpu or --loss=none", FLAGS_loss);
  return true;
}

CallbackResult AfterIteration(const LmIteration& row) {
  if (FLAGS_log_lm) {
    fmt::print(stderr, "{:4} cost {:.6e} lambda {:.1e} pcg {:4}{}\n", row.iteration, row.cost, row.lambda,
               row.pcg_iterations, row.accepted || row.iteration == 0 ? "" : " rejected");
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

void WriteJson(const LmSummary& summary, const bundle::BundleData& data, double rms_before, double rms_after,
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
  WriteFileAtomically(FLAGS_json, json.dump(1) + "\n");
}

}  // namespace

int RunBundleAdjust(const Arguments& arguments) {
  const bool on_gpu = SolvesOnGpu();
  CheckWritable("out", FLAGS_out);
  if (!FLAGS_json.empty()) CheckWritable("json", FLAGS_json);
  bundle::BundleData data = bundle::ReadBal(arguments[0]);
  bundle::BundleProblem problem(data, {.loss = LossOfFlags()});
  const HostSpan<double> x(data.x.data(), static_cast<Index>(data.x.size()));
  const double rms_before = RmsError(problem, x);

  CatchInterrupts();
  LmOptions options = bundle::BundleLmOptions();
  SetOptionsOfFlags(options);
  Cpu backend;
  const LmSummary summary = on_gpu ? SolveBundleOnGpu(data, SetOptionsOfFlags, AfterIteration)
                                   : SolveLm<Cpu>(options, backend, problem, x, AfterIteration);
  if (FLAGS_log_lm) fmt::print(stderr, "{}", summary.FullReport());
  if (summary.status == LmStatus::kNonFinite) {
    Fail("{}: {}; a point may lie in the plane of a camera that sees it", arguments[0], summary.message);
  }
  bundle::WriteBal(FLAGS_out, data);
  const double rms_after = RmsError(problem, x);
  if (!FLAGS_json.empty()) WriteJson(summary, data, rms_before, rms_after, on_gpu ? "cuda" : "cpu");
  fmt::print("{} cameras, {} points, {} observations\n{}\n", data.num_cameras, data.num_points,
             data.observations.size(), summary.BriefReport());
  fmt::print("reprojection error {:.4f} -> {:.4f} pixels (root mean square); wrote {}\n", rms_before, rms_after,
             FLAGS_out);
  return Interrupted() ? kInterruptedStatus : 0;
}

}  // namespace vesta::app
