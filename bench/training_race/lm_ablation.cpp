// Every part of LM changed on its own, on one scene, from one state that Adam left, at equal time.
//
//   lm_ablation SCENE [--budget X] [--knobs PART_OF_KNOB,...] [--repeats N] [--evaluations N] [--json FILE]
//               [--curves FILE] [-- flags of vesta train]
//
// The flags after "--" make the reference; variants.cpp lists what is changed. LM goes on for --budget times as long as
// the reference's Adam stage took (default 1), whatever --lm_iterations and lm.min_gain say; what trains from the
// points ("when to switch", "no LM") has the time of both. Figures are those at that very time, on the straight line
// between the evaluations before and after it; medians of the repeats, which go round all variants. --evaluations: rows
// of an Adam stage. The rows "noise" change next to nothing: a difference smaller than theirs is no difference.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "bench/training_race/setup.h"
#include "bench/training_race/training_run.h"
#include "bench/training_race/variants.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::bench {
namespace {

// Differences below these are never reported.
constexpr double kLeastPsnr = 0.02, kLeastCost = 0.3;  // dB, percent

struct Outcome {
  Variant variant;
  std::vector<gs::HistoryRow> ends;  // of each repeat, at the end of the time
  std::vector<int> iterations;       // of LM
  double peak_mib = 0;

  template <class Value>
  double Median(const Value& value) const {
    std::vector<double> values;
    values.reserve(ends.size());
    for (const gs::HistoryRow& row : ends) values.push_back(value(row));
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }
  double Cost() const {
    return Median([](const auto& row) { return row.cost; });
  }
  double TrainPsnr() const {
    return Median([](const auto& row) { return row.train.psnr; });
  }
  double TestPsnr() const {
    return Median([](const auto& row) { return row.test.psnr; });
  }
  double TestSsim() const {
    return Median([](const auto& row) { return row.test.ssim; });
  }
};

// Of a variant against the reference.
struct Difference {
  double psnr;  // dB, of the test views
  double cost;  // percent
};

Difference Compare(const Outcome& outcome, const Outcome& reference) {
  return {outcome.TestPsnr() - reference.TestPsnr(), 100 * (outcome.Cost() / reference.Cost() - 1)};
}

std::string Conclusion(const Difference& difference, const Difference& noise) {
  const auto part = [](double value, double noise_level, const char* up, const char* down, const std::string& amount) {
    if (!std::isfinite(value)) return std::string("not a number");
    return std::abs(value) <= noise_level ? std::string() : fmt::format("{} {}", value > 0 ? up : down, amount);
  };
  const std::string psnr = part(difference.psnr, noise.psnr, "better by", "worse by",
                                fmt::format("{:.2f} dB of test PSNR", std::abs(difference.psnr)));
  const std::string cost = part(difference.cost, noise.cost, "cost higher by", "cost lower by",
                                fmt::format("{:.1f} %", std::abs(difference.cost)));
  if (psnr.empty() && cost.empty()) return "no difference beyond the noise";
  return psnr + (psnr.empty() || cost.empty() ? "" : "; ") + cost;
}

class Ablation {
 public:
  Ablation(const RaceSetup& setup, double budget) : setup_(setup) {
    gs::TrainOptions adam = setup.options;
    adam.lm.iterations = 0;
    adam.time_limit = 0;
    TrainingRun run = TrainAlone(setup.scene, {.name = "Adam's state", .options = adam}, setup.threads);
    start_ = std::move(run.lm_start);
    start_seconds_ = run.curve.back().seconds;
    end_seconds_ = start_seconds_ * (1 + budget);
    fmt::print("{}: Adam's state after {:.2f} s: {} Gaussians, cost {:.5f}, test {:.3f} dB {:.4f}; {:.2f} s in all\n",
               setup.scene_name, start_seconds_, start_.count, run.curve.back().cost, run.curve.back().test.psnr,
               run.curve.back().test.ssim, end_seconds_);
  }

  void Run(Outcome* outcome, std::ostream* curves) const {
    constexpr int kUntilTheTimeIsUp = 1'000'000;
    const Variant& variant = outcome->variant;
    TrainingJob job{.name = variant.knob + ", " + variant.name, .options = variant.options};
    if (job.options.lm.iterations > 0) job.options.lm.iterations = kUntilTheTimeIsUp, job.options.lm.min_gain = 0;
    job.options.time_limit = 0;
    job.training_seconds = end_seconds_;
    if (!variant.from_points) job.start = &start_, job.seconds_before = start_seconds_;
    const TrainingRun run = TrainAlone(setup_.scene, job, setup_.threads);
    const gs::HistoryRow end = At(run.curve, end_seconds_);
    std::fprintf(stderr, "%s: %s: cost %.5f, test %.3f dB %.4f\n", setup_.scene_name.c_str(), job.name.c_str(),
                 end.cost, end.test.psnr, end.test.ssim);
    outcome->peak_mib = std::max(outcome->peak_mib, run.peak_mib);
    outcome->iterations.push_back(end.stage == gs::Stage::kLm ? end.iteration : 0);
    outcome->ends.push_back(end);
    if (curves) WriteCsv(setup_.scene_name, job.name, run.curve, *curves);
  }

 private:
  const RaceSetup& setup_;
  gs::SplatModel start_;
  double start_seconds_ = 0, end_seconds_ = 0;
};

bool IsWanted(const Variant& variant, const std::vector<std::string>& knobs) {
  if (knobs.empty() || variant.knob == "reference" || variant.knob == "noise") return true;
  return std::any_of(knobs.begin(), knobs.end(),
                     [&](const std::string& part) { return variant.knob.find(part) != std::string::npos; });
}

void Tell(const std::string& scene, const std::vector<Outcome>& outcomes, Report* report) {
  const Outcome& reference = outcomes.front();
  Difference noise{kLeastPsnr, kLeastCost};
  for (const Outcome& outcome : outcomes) {
    if (outcome.variant.knob != "noise") continue;
    const Difference difference = Compare(outcome, reference);
    noise.psnr = std::max(noise.psnr, std::abs(difference.psnr));
    noise.cost = std::max(noise.cost, std::abs(difference.cost));
  }
  fmt::print("{}: noise: {:.3f} dB of test PSNR, {:.2f} % of the cost\n", scene, noise.psnr, noise.cost);
  for (const Outcome& outcome : outcomes) {
    const Difference difference = Compare(outcome, reference);
    report->Add({{"scene", scene},
                 {"knob", outcome.variant.knob},
                 {"variant", outcome.variant.name},
                 {"LM iterations", static_cast<double>(outcome.iterations.front())},
                 {"cost", outcome.Cost()},
                 {"train PSNR", outcome.TrainPsnr()},
                 {"test PSNR", outcome.TestPsnr()},
                 {"test SSIM", outcome.TestSsim()},
                 {"d cost %", difference.cost},
                 {"d PSNR", difference.psnr},
                 {"peak MiB", outcome.peak_mib},
                 {"conclusion", &outcome == &reference ? "the reference" : Conclusion(difference, noise)}});
  }
}

double Budget(const Arguments& arguments) {
  const std::string text = arguments.Flag("budget", "1");
  char* end = nullptr;
  const double budget = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !(budget > 0 && budget <= 1000)) Fail("--budget={}: choose a number above 0", text);
  return budget;
}

int Main(int argc, char** argv) {
  const RaceSetup setup = SetUpRace(argc, argv, {"budget", "knobs", "repeats", "evaluations", "json", "curves"});
  const double budget = Budget(setup.arguments);
  const int repeats = setup.arguments.Count("repeats", 3), evaluations = setup.arguments.Count("evaluations", 40);
  const std::vector<std::string> knobs = SplitAtCommas(setup.arguments.Flag("knobs", ""));
  std::ofstream curves = OpenCurves(setup.arguments);

  std::vector<Outcome> outcomes;
  for (Variant& variant : Variants(setup.options, budget)) {
    if (!IsWanted(variant, knobs)) continue;
    variant.options.adam.evaluations = evaluations;
    gs::ValidateOptions(variant.options);
    outcomes.push_back({.variant = std::move(variant), .ends = {}, .iterations = {}});
  }
  const Ablation ablation(setup, budget);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (Outcome& outcome : outcomes) ablation.Run(&outcome, repeat == 0 && curves.is_open() ? &curves : nullptr);
  }
  Report report("lm_ablation");
  Tell(setup.scene_name, outcomes, &report);
  SetNumThreads(setup.threads);  // the report says on how many
  report.Finish(setup.arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("lm_ablation", vesta::bench::Main, argc, argv); }
