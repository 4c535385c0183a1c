// SPDX-License-Identifier: Apache-2.0
// Compares Levenberg-Marquardt with Adam on one scene from the same start: the time to Adam's best test quality.
//
//   lm_vs_adam SCENE [--methods ours,paper,adam] [--lengths N,...] [--rate_factors X,...]
//              [--repeats N] [--evaluations N] [--json FILE] [--curves FILE]
//              [-- flags of vesta train]
//
// The flags after "--" set the options of the method `ours` and the number of threads; the other methods share its
// start (methods.h). Each training runs in its own process. Repeats alternate between the methods, so that noise of the
// machine affects all equally. The median of their times is used. After the
// first round an Adam schedule is dropped if it misses the target, or takes at least twice as long as the fastest.
// Seconds exclude loading and evaluation. --evaluations: evenly spaced rows in each Adam stage; an LM stage has one row
// per iteration. --curves writes all rows as CSV for bench/training_race/plot.py, with the quality to reach as method
// "target". The flag --time_limit of `vesta train` applies to each method.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>

#include "bench/report.h"
#include "bench/training_race/methods.h"
#include "bench/training_race/quality_target.h"
#include "bench/training_race/setup.h"
#include "bench/training_race/training_run.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::bench {
namespace {

// Goals for vesta's figure divided by the other method's.
constexpr double kGoalAgainstAdam = 1.0;           // time to Adam's best quality; 0.7 for the mean over scenes
constexpr double kGoalAgainstPublished = 1.0 / 3;  // time to the final cost of the published LM
constexpr double kGoalMemory = 1.3;                // peak memory, relative to Adam alone

struct Outcome {
  Method method;
  std::vector<Curve> repeats;
  bool is_settled = false;           // no further repeat is needed
  std::vector<double> stage_starts;  // seconds, per repeat
  double peak_mib = 0;               // minimum over the repeats
  double adam_peak_mib = 0;          // the same for the Adam stage
  Curve curve;                       // median
};

double LmStageStart(const Curve& curve) {
  double seconds = 0;
  for (const gs::HistoryRow& row : curve) {
    if (row.stage == gs::Stage::kAdam) seconds = row.seconds;
  }
  return seconds;
}

// Runs every method once. `start`: the model of `ours` at the begin of its LM stage.
void RunRound(const RaceSetup& setup, std::vector<Outcome>* outcomes) {
  gs::SplatModel start;
  double start_seconds = 0;
  for (Outcome& outcome : *outcomes) {
    TrainingJob job{.name = outcome.method.name, .options = outcome.method.options};
    if (outcome.is_settled) continue;
    const bool starts_at_lm = StartsAtLm(outcome.method.kind);
    if (starts_at_lm) {
      if (start.count == 0) Fail(kUnavailable, "the method ours did not reach its LM stage; give it more time");
      job.start = &start;
      job.seconds_before = start_seconds;
    }
    TrainingRun run = TrainAlone(setup.scene, job, setup.threads);
    if (outcome.method.kind == MethodKind::kOurs) {
      start = std::move(run.lm_start);
      start_seconds = LmStageStart(run.curve);
    } else if (!starts_at_lm) {
      start = {};  // memory of this process would count as memory of its children
    }
    const bool is_first = outcome.repeats.empty();
    outcome.peak_mib = is_first ? run.peak_mib : std::min(outcome.peak_mib, run.peak_mib);
    outcome.adam_peak_mib = is_first ? run.adam_peak_mib : std::min(outcome.adam_peak_mib, run.adam_peak_mib);
    outcome.stage_starts.push_back(start_seconds);
    const gs::HistoryRow& end = run.curve.back();
    std::fprintf(stderr, "%s: %s: %.2f s, training loss %.5f, test %.3f dB %.4f, %lld Gaussians, %.0f MiB\n",
                 setup.scene_name.c_str(), outcome.method.name.c_str(), end.seconds, end.cost, end.test.psnr,
                 end.test.ssim, static_cast<long long>(end.gaussians), run.peak_mib);
    outcome.repeats.push_back(std::move(run.curve));
  }
}

std::vector<const Curve*> AdamCurves(const std::vector<Outcome>& outcomes) {
  std::vector<const Curve*> curves;
  for (const Outcome& outcome : outcomes) {
    if (outcome.method.kind == MethodKind::kAdam) curves.push_back(&outcome.curve);
  }
  return curves;
}

double FastestTo(const QualityTarget& target, const std::vector<const Curve*>& curves) {
  double seconds = std::numeric_limits<double>::infinity();
  for (const Curve* curve : curves) seconds = std::min(seconds, SecondsTo(target, *curve));
  return seconds;
}

// Drops Adam schedules too slow to be the fastest by noise.
void SettleSlowAdam(std::vector<Outcome>* outcomes) {
  const std::vector<const Curve*> curves = AdamCurves(*outcomes);
  if (curves.empty()) return;
  const QualityTarget target = BestQuality(curves);
  const double fastest = FastestTo(target, curves);
  for (Outcome& outcome : *outcomes) {
    outcome.is_settled = outcome.method.kind == MethodKind::kAdam && !(SecondsTo(target, outcome.curve) < 2 * fastest);
  }
}

const Outcome* Find(const std::vector<Outcome>& outcomes, const std::string& name) {
  const auto found = std::find_if(outcomes.begin(), outcomes.end(),
                                  [&](const Outcome& outcome) { return outcome.method.name == name; });
  return found == outcomes.end() ? nullptr : &*found;
}

// Adam only, with the schedule of `ours`.
const Outcome* SameAdam(const std::vector<Outcome>& outcomes, const Outcome& ours) {
  for (const Outcome& outcome : outcomes) {
    if (outcome.method.kind == MethodKind::kAdam &&
        outcome.method.options.adam.iterations == ours.method.options.adam.iterations &&
        outcome.method.options.adam.lr_scale == ours.method.options.adam.lr_scale) {
      return &outcome;
    }
  }
  return nullptr;
}

// Seconds from the begin of the LM stage to this cost.
double StageSecondsTo(const Outcome& outcome, double cost) {
  Curve stage = outcome.curve;
  std::erase_if(stage, [](const gs::HistoryRow& row) { return row.stage != gs::Stage::kLm; });
  return SecondsToCost(stage, cost) - Median(outcome.stage_starts);
}

void CompareStages(const std::string& scene, const std::vector<Outcome>& outcomes, Report* report) {
  const Outcome* ours = Find(outcomes, "our LM");
  const Outcome *paper = Find(outcomes, "paper"), *code = Find(outcomes, "paper_code");
  if (!ours || !paper || !code) return;
  const Outcome& better = LowestCost(paper->curve) <= LowestCost(code->curve) ? *paper : *code;
  const double cost = LowestCost(better.curve);
  const double ratio = StageSecondsTo(*ours, cost) / StageSecondsTo(better, cost);
  report->AddTarget(
      {fmt::format("{}: LM stage to the final cost of {} ({:.5f}), ours / theirs", scene, better.method.name, cost),
       ratio, "x", kGoalAgainstPublished, ratio <= kGoalAgainstPublished});
}

void CompareMemory(const std::string& scene, const std::vector<Outcome>& outcomes, Report* report) {
  const Outcome* ours = Find(outcomes, "ours");
  if (!ours) return;
  const auto compare = [&](const char* with, double mib) {
    const double ratio = ours->peak_mib / mib;
    report->AddTarget(
        {fmt::format("{}: peak memory, ours / {}", scene, with), ratio, "x", kGoalMemory, ratio <= kGoalMemory});
  };
  compare("its own Adam stage", ours->adam_peak_mib);
  if (const Outcome* adam = SameAdam(outcomes, *ours)) compare("Adam alone", adam->peak_mib);
}

void Tell(const std::string& scene, const std::vector<Outcome>& outcomes, Report* report, std::ostream* curves) {
  const std::vector<const Curve*> adam = AdamCurves(outcomes);
  const bool has_target = !adam.empty();
  QualityTarget target;
  double adam_seconds = std::numeric_limits<double>::quiet_NaN();
  if (has_target) {
    target = BestQuality(adam);
    adam_seconds = FastestTo(target, adam);
    fmt::print("{}: Adam's best test PSNR {:.3f} dB and SSIM {:.4f} on all its curves; target: {:.3f} and {:.4f}{}\n",
               scene, target.best_psnr, target.best_ssim, target.psnr, target.ssim,
               target.tolerance_factor > 1
                   ? fmt::format(" (tolerances times {:.2f}: no row reaches both with the normal ones)",
                                 target.tolerance_factor)
                   : "");
  }
  for (const Outcome& outcome : outcomes) {
    const gs::HistoryRow &psnr = BestPsnr(outcome.curve), &ssim = BestSsim(outcome.curve), &end = outcome.curve.back();
    const double seconds = has_target ? SecondsTo(target, outcome.curve) : adam_seconds;
    report->Add({{"scene", scene},
                 {"method", outcome.method.name},
                 {"s in all", end.seconds},
                 {"gaussians", static_cast<double>(end.gaussians)},
                 {"cost", LowestCost(outcome.curve)},
                 {"train PSNR", end.train.psnr},
                 {"best PSNR", psnr.test.psnr},
                 {"at s", psnr.seconds},
                 {"best SSIM", ssim.test.ssim},
                 {"SSIM at s", ssim.seconds},
                 {"s to target", seconds},
                 {"of Adam's", seconds / adam_seconds},
                 {"peak MiB", outcome.peak_mib}});
    if (curves) WriteCsv(scene, outcome.method.name, outcome.curve, *curves);
  }
  const Outcome* ours = Find(outcomes, "ours");
  if (has_target && curves) {
    gs::HistoryRow row;
    row.seconds = adam_seconds, row.test.psnr = target.psnr, row.test.ssim = target.ssim;
    WriteCsv(scene, "target", {row}, *curves);
  }
  if (has_target && ours) {
    const double ratio = SecondsTo(target, ours->curve) / adam_seconds;
    report->AddTarget(
        {fmt::format("{}: seconds to Adam's best test quality, ours / Adam ({:.2f} s)", scene, adam_seconds), ratio,
         "x", kGoalAgainstAdam, ratio < kGoalAgainstAdam});
  }
  CompareStages(scene, outcomes, report);
  CompareMemory(scene, outcomes, report);
}

int Main(int argc, char** argv) {
  const RaceSetup setup =
      SetUpRace(argc, argv, {"methods", "lengths", "rate_factors", "repeats", "evaluations", "json", "curves"});
  const auto training_views = static_cast<int>(std::count_if(setup.scene.views.begin(), setup.scene.views.end(),
                                                             [](const auto& view) { return view.is_trained(); }));
  std::ofstream curves = OpenCurves(setup.arguments);
  std::vector<Outcome> outcomes;
  for (Method& method : SelectMethods(setup.arguments, setup.options, training_views)) {
    outcomes.push_back({.method = std::move(method), .repeats = {}, .stage_starts = {}, .curve = {}});
  }
  const int repeats = setup.arguments.Count("repeats", 3);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    RunRound(setup, &outcomes);
    for (Outcome& outcome : outcomes) outcome.curve = MedianCurve(outcome.repeats);
    if (repeat == 0) SettleSlowAdam(&outcomes);
  }

  Report report("lm_vs_adam");
  Tell(setup.scene_name, outcomes, &report, curves.is_open() ? &curves : nullptr);
  SetNumThreads(setup.threads);  // printed by the report
  report.Finish(setup.arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("lm_vs_adam", vesta::bench::Main, argc, argv); }
