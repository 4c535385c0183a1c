// SPDX-License-Identifier: Apache-2.0
// Compares the pull of Gaussians (splatting/density/density_steps.h) with the gain of their splits.
//
//   split_calibration SCENE [--at X] [--classes N] [--epochs N] [--json FILE] [-- flags of vesta train]
//
// Trains with vesta's growth, without pruning, to the fraction X of the stage and measures the pulls over one epoch.
// Then it divides the Gaussians into N classes of equal size by pull. From the same state, it splits the Gaussians of
// one class, trains on for N epochs (default: to the end of the stage), and compares the loss of the training views,
// and the squared error of the test views, with a training that splits none.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "bench/growth/bare_stage.h"
#include "bench/training_race/setup.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::bench {
namespace {

struct Errors {
  double train = 0;  // loss per pixel value
  double test = 0;   // squared error per pixel value, from the mean PSNR
};

Errors ErrorsOf(BareStage& stage) {
  const gs::Evaluation evaluation = stage.Evaluate();
  return {evaluation.cost, std::pow(10, -evaluation.test.psnr / 10)};
}

int ViewsOf(const BareStage& stage) { return static_cast<int>(stage.session().training_views().size()); }

void TrainEpochs(BareStage& stage, std::int64_t epochs) {
  for (std::int64_t k = 0; k < epochs * ViewsOf(stage) && stage.done() < stage.iterations(); ++k)
    stage.Step(stage.NextPlan());
}

double Price(BareStage& stage, double epochs) { return gs::GaussianPrice(stage.mean_cost(), epochs); }

// Grows as a training does, until this fraction of the stage.
void TrainUntil(BareStage& stage, double at) {
  while (stage.done() < at * stage.iterations()) {
    const gs::IterationPlan plan = stage.NextPlan();
    stage.Step(plan);
    const double epochs = static_cast<double>(stage.model().density().views()) / ViewsOf(stage);
    if (plan.densifies) stage.model().Densify(Price(stage, epochs), [] {});
  }
}

// Splits the Gaussians that are `chosen`, and no others.
void Split(BareStage& stage, const std::vector<bool>& chosen) {
  HostBuffer<float>& pull = stage.model().density().pull();
  for (Index i = 0; i < pull.size(); ++i) {
    pull[i] = chosen[static_cast<std::size_t>(i)] ? std::numeric_limits<float>::max() : 0.0f;
  }
  stage.model().Densify(Price(stage, 1), [] {});
}

// Spearman's rank correlation of values without ties.
double RankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto ranks = [](const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t k) { return values[k]; });
    std::vector<double> rank(values.size());
    for (std::size_t k = 0; k < order.size(); ++k) rank[order[k]] = static_cast<double>(k);
    return rank;
  };
  const std::vector<double> ra = ranks(a), rb = ranks(b);
  double squares = 0;
  for (std::size_t k = 0; k < ra.size(); ++k) squares += (ra[k] - rb[k]) * (ra[k] - rb[k]);
  const auto n = static_cast<double>(a.size());
  return 1 - 6 * squares / (n * (n * n - 1));
}

int Main(int argc, char** argv) {
  RaceSetup setup = SetUpRace(argc, argv, {"at", "classes", "epochs", "json"});
  setup.options.density.prune_opa = setup.options.density.prune_scale3d = 0;
  setup.options.adam.half_resolution_until = 0;
  SetNumThreads(setup.threads);
  const double at = std::strtod(setup.arguments.Flag("at", "0.35").c_str(), nullptr);
  if (!(at > 0) || !(at < setup.options.density.end)) {
    Fail(kBadArgument, "--at={}: choose a fraction between 0 and density.end", setup.arguments.Flag("at", ""));
  }
  const int classes = setup.arguments.Count("classes", 10), epochs = setup.arguments.Count("epochs", 10000000);
  BareStage stage(setup.scene, setup.options);
  TrainUntil(stage, at);
  const Index count = stage.model().count();
  if (count < classes) Fail(kBadArgument, "--classes={}: there are only {} Gaussians", classes, count);
  stage.model().density().ResetStatistics(count);
  TrainEpochs(stage, 1);
  const HostBuffer<float>& pull = stage.model().density().pull();
  const std::vector<float> pulls(pull.begin(), pull.end());
  std::vector<std::size_t> order(pulls.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return pulls[i]; });
  const std::string state = stage.Save();
  const double price = Price(stage, 1);

  Split(stage, std::vector<bool>(pulls.size(), false));
  TrainEpochs(stage, epochs);
  const Errors control = ErrorsOf(stage);
  Report report("split_calibration");
  std::vector<double> scores, train_gains, test_gains;
  for (int k = 0; k < classes; ++k) {
    const auto place = [&](int c) {
      return pulls.size() * static_cast<std::size_t>(c) / static_cast<std::size_t>(classes);
    };
    std::vector<bool> chosen(pulls.size());
    double sum = 0;
    for (std::size_t r = place(k); r < place(k + 1); ++r) chosen[order[r]] = true, sum += pulls[order[r]];
    stage.Restore(state);
    Split(stage, chosen);
    TrainEpochs(stage, epochs);
    const Errors errors = ErrorsOf(stage);
    scores.push_back(sum / static_cast<double>(place(k + 1) - place(k)) / price);
    train_gains.push_back(1 - errors.train / control.train);
    test_gains.push_back(1 - errors.test / control.test);
    report.Add({{"scene", setup.scene_name},
                {"class", static_cast<double>(k + 1)},
                {"pull, prices", scores.back()},
                {"training loss falls by, %", 100 * train_gains.back()},
                {"test squared error falls by, %", 100 * test_gains.back()}});
  }
  for (const auto& [of, gains] : {std::pair("training loss", &train_gains), std::pair("test error", &test_gains)}) {
    const double value = RankCorrelation(scores, *gains);
    report.AddTarget({std::string("rank correlation of pull and fall of the ") + of, value, "", 0.9, value >= 0.9});
  }
  report.Finish(setup.arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  return vesta::bench::ReportErrors("split_calibration", vesta::bench::Main, argc, argv);
}
