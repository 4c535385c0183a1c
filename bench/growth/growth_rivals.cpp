// SPDX-License-Identifier: Apache-2.0
// Compares vesta's growth with 3DGS-MCMC at equal numbers of Gaussians and iterations.
//
//   growth_rivals SCENE [--factors X,...] [--seeds N,...] [--json FILE] [-- flags of vesta train]
//
// Trains with each factor as density.grow_pull. The factor decides the number of Gaussians. MCMC (mcmc.h) then trains
// with the same number. Each training runs in its own process.
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <utility>

#include "bench/child_process.h"
#include "bench/growth/mcmc.h"
#include "bench/training_race/setup.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::bench {
namespace {

struct Outcome {
  double gaussians = 0, psnr = 0, ssim = 0, cpu_seconds = 0;
};

Outcome OutcomeOf(const gs::Quality& test, Index gaussians) {
  return {static_cast<double>(gaussians), test.psnr, test.ssim, static_cast<double>(std::clock()) / CLOCKS_PER_SEC};
}

template <class TrainOnce>
Outcome InChild(const RaceSetup& setup, const std::string& name, const TrainOnce& train) {
  const ChildResult child = RunInChild(name, [&](const Send& send) {
    SetNumThreads(setup.threads);
    const Outcome outcome = train();
    send(&outcome, sizeof outcome);
  });
  Outcome outcome;
  if (child.failed || child.bytes.size() != sizeof outcome) Fail(kUnavailable, "{}: the training failed", name);
  std::memcpy(&outcome, child.bytes.data(), sizeof outcome);
  return outcome;
}

Outcome TrainOurs(const gs::Scene& scene, const gs::TrainOptions& options) {
  const gs::TrainResult result = gs::Train(scene, options, {}, {});
  return OutcomeOf(result.history.back().test, result.model.count);
}

Outcome TrainMcmc(const gs::Scene& scene, const gs::TrainOptions& options, Index gaussians) {
  const McmcResult result = TrainByMcmc(scene, options, {.gaussians = gaussians});
  return OutcomeOf(result.evaluation.test, result.gaussians);
}

int Main(int argc, char** argv) {
  RaceSetup setup = SetUpRace(argc, argv, {"factors", "seeds", "json"});
  setup.options.lm.iterations = 0;
  setup.options.adam.evaluations = 1;
  Report report("growth_rivals");
  for (const std::string& factor : SplitAtCommas(setup.arguments.Flag("factors", "25,50,100,200"))) {
    for (const std::string& seed : SplitAtCommas(setup.arguments.Flag("seeds", "0,1,2"))) {
      gs::TrainOptions options = setup.options;
      options.density.grow_pull = std::strtod(factor.c_str(), nullptr);
      options.seed = std::strtoull(seed.c_str(), nullptr, 10);
      gs::ValidateOptions(options);
      const Outcome ours = InChild(setup, "ours", [&] { return TrainOurs(setup.scene, options); });
      const auto number = static_cast<Index>(ours.gaussians);
      const Outcome mcmc = InChild(setup, "MCMC", [&] { return TrainMcmc(setup.scene, options, number); });
      for (const auto& [name, outcome] : {std::pair("vesta", ours), std::pair("MCMC", mcmc)}) {
        report.Add({{"scene", setup.scene_name},
                    {"grow_pull", options.density.grow_pull},
                    {"seed", static_cast<double>(options.seed)},
                    {"growth", name},
                    {"Gaussians", outcome.gaussians},
                    {"test PSNR, dB", outcome.psnr},
                    {"test SSIM", outcome.ssim},
                    {"CPU seconds", outcome.cpu_seconds}});
      }
    }
  }
  SetNumThreads(setup.threads);  // printed by the report
  report.Finish(setup.arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("growth_rivals", vesta::bench::Main, argc, argv); }
