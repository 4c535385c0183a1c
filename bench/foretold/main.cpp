// What vesta foretells of a change to a splat beside the truth, images rendered with the change: by how much the cost
// of the training views rises.
//
//   foretold SPLAT SCENE [--of gaussians|degrees|batches] [--count 500] [--downscale 1] [--views 64] [--seed 0]
//            [--json FILE]
//
// Of `count` Gaussians drawn at random among those that some view shows: without them, or with harmonics of a lower
// degree; or of twenty batches of a tenth of all. Of many views only so many are looked at.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "bench/foretold/experiments.h"
#include "bench/report.h"
#include "problems/gaussian_splatting/io/load_scene.h"
#include "problems/gaussian_splatting/io/splat_file.h"
#include "problems/gaussian_splatting/model/degrees.h"
#include "problems/gaussian_splatting/model/scene_frame.h"

namespace vesta::bench {
namespace {

std::vector<double> Ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t k = 0; k < order.size(); ++k) ranks[order[k]] = static_cast<double>(k);
  return ranks;
}

// Of ranks (Spearman).
double RankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> ra = Ranks(a), rb = Ranks(b);
  double squares = 0;
  for (std::size_t k = 0; k < ra.size(); ++k) squares += (ra[k] - rb[k]) * (ra[k] - rb[k]);
  const auto n = static_cast<double>(a.size());
  return 1 - 6 * squares / (n * (n * n - 1));
}

double Quantile(std::vector<double> values, double part) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

gs::JudgingViews JudgesOf(const gs::Scene& scene, const gs::SplatModel& model, std::size_t most) {
  gs::JudgingViews judges =
      gs::TrainingViewsOf(scene, {static_cast<double>(model.background[0]), static_cast<double>(model.background[1]),
                                  static_cast<double>(model.background[2])});
  const std::vector<const gs::View*> all = judges.views;
  if (all.size() <= most) return judges;
  judges.views.clear();
  for (std::size_t k = 0; k < most; ++k) judges.views.push_back(all[k * all.size() / most]);
  return judges;
}

Foretold Ask(const std::string& of, JudgedModel& judged, double extent, int count, std::uint64_t seed) {
  if (of == "gaussians") return RemoveGaussians(judged, count, seed);
  if (of == "degrees") return LowerDegrees(judged, count, seed);
  if (of == "batches") return RemoveBatches(judged, extent, seed);
  throw Error("--of is gaussians, degrees or batches");
}

int Main(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"of", "count", "downscale", "views", "seed", "json"});
  if (arguments.positional.size() != 2) throw Error("the form is `foretold SPLAT SCENE`");
  gs::SplatModel model = gs::AtOneDegree(gs::ReadSplat(arguments.positional[0]));
  gs::LoadSceneOptions options;
  options.downscale = arguments.Count("downscale", 1);
  options.background = model.background, options.low_pass = model.low_pass;
  const gs::Scene scene = gs::LoadScene(arguments.positional[1], options);
  gs::MoveToScene(scene, &model);
  const gs::JudgingViews judges = JudgesOf(scene, model, static_cast<std::size_t>(arguments.Count("views", 64)));
  JudgedModel judged(model, judges);
  const std::string of = arguments.Flag("of", "gaussians");
  const auto [said, truth] = Ask(of, judged, scene.extent, arguments.Count("count", 500),
                                 static_cast<std::uint64_t>(std::stoull(arguments.Flag("seed", "0"))));
  std::vector<double> ratios;
  for (std::size_t k = 0; k < said.size(); ++k) {
    if (truth[k] != 0) ratios.push_back(said[k] / truth[k]);
  }
  if (ratios.empty()) throw Error(arguments.positional[0] + ": nothing that was changed changes the cost");

  Report report("foretold");
  const double correlation = RankCorrelation(said, truth), ratio = Quantile(ratios, 0.5);
  report.Add({{"splat", arguments.positional[0]},
              {"of", of},
              {"gaussians", static_cast<double>(model.count)},
              {"views", static_cast<double>(judges.views.size())},
              {"changes", static_cast<double>(said.size())},
              {"rank_correlation", correlation},
              {"ratio_10", Quantile(ratios, 0.1)},
              {"ratio_50", ratio},
              {"ratio_90", Quantile(ratios, 0.9)},
              {"median_rise", Quantile(truth, 0.5) / judged.cost()},
              {"better_so", static_cast<double>(std::ranges::count_if(truth, [](double x) { return x < 0; }))}});
  report.AddTarget({"rank correlation of foretold and true rises", correlation, "", 0.9, correlation >= 0.9});
  report.AddTarget({"median ratio of foretold and true rises", ratio, "", 1, ratio >= 0.7 && ratio <= 1.4});
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("foretold", vesta::bench::Main, argc, argv); }
