// By how much the cost of the training views rises without a Gaussian: what vesta foretells
// (kernels/gaussian_splatting/removal.h) beside the truth, an image rendered without it.
//
//   removals SPLAT SCENE [--count 500] [--downscale 1] [--views 64] [--seed 0] [--json FILE]
//
// Gaussians are drawn at random among those that some view shows; of many views only so many are looked at.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/report.h"
#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/splat_view.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/io/load_scene.h"
#include "problems/gaussian_splatting/io/splat_file.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "problems/gaussian_splatting/parsimony/worth.h"

namespace vesta::bench {
namespace {

// The judges' cost, view by view.
class ViewCosts {
 public:
  ViewCosts(const gs::SplatModel& model, const gs::JudgingViews& judges) : model_(model), judges_(judges) {
    costs_.reserve(judges.views.size());
    for (const gs::View* view : judges.views) {
      costs_.push_back(CostIn(*view));
      seen_.emplace_back(splats_.rank_of().begin(), splats_.rank_of().end());
    }
  }
  // Of the cost, when Gaussian i is not there.
  double RiseWithout(Index i) {
    constexpr float kNone = -100;
    float& logit = model_.attribute(splat::kOpacity)[i];
    const float before = std::exchange(logit, kNone);
    double rise = 0;
    for (std::size_t v = 0; v < costs_.size(); ++v) {
      if (seen_[v][static_cast<std::size_t>(i)] >= 0) rise += CostIn(*judges_.views[v]) - costs_[v];
    }
    logit = before;
    return rise;
  }

 private:
  double CostIn(const gs::View& view) {
    const ImageShape shape{view.camera.width, view.camera.height};
    image_.ResizeForOverwrite(shape.NumValues());
    splats_.Build(gs::ToKernelModel(model_), gs::ToPosedCamera(view, judges_.near), judges_.background.data(),
                  workspace_);
    splats_.Render(image_.data());
    return loss_.Evaluate(image_, {view.image.rgb.data(), shape.NumValues()}, shape).objective;
  }

  gs::SplatModel model_;
  const gs::JudgingViews& judges_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
  PhotometricLoss<float> loss_;
  HostBuffer<float> image_;
  std::vector<double> costs_;
  std::vector<std::vector<std::int32_t>> seen_;
};

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

// Different ones that have a share of some pixel.
std::vector<Index> Draw(const gs::Worth& worth, int count, std::uint64_t seed) {
  std::vector<Index> seen;
  for (std::size_t i = 0; i < worth.weight.size(); ++i) {
    if (worth.weight[i] > 0) seen.push_back(static_cast<Index>(i));
  }
  CounterRandom random(seed, 0);
  const std::size_t most = std::min(seen.size(), static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < most; ++k) {
    std::swap(seen[k], seen[k + static_cast<std::size_t>(random.Below(static_cast<Index>(seen.size() - k)))]);
  }
  seen.resize(most);
  return seen;
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

int Main(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"count", "downscale", "views", "seed", "json"});
  if (arguments.positional.size() != 2) throw Error("the form is `removals SPLAT SCENE`");
  gs::SplatModel model = gs::ReadSplat(arguments.positional[0]);
  gs::LoadSceneOptions options;
  options.downscale = arguments.Count("downscale", 1);
  options.background = model.background;
  const gs::Scene scene = gs::LoadScene(arguments.positional[1], options);
  gs::MoveToScene(scene, &model);
  const gs::JudgingViews judges = JudgesOf(scene, model, static_cast<std::size_t>(arguments.Count("views", 64)));

  const gs::Worth worth = gs::MeasureWorth(gs::ToKernelModel(model), judges);
  ViewCosts costs(model, judges);
  std::vector<double> said, truth, ratios;
  for (const Index i : Draw(worth, arguments.Count("count", 500),
                            static_cast<std::uint64_t>(std::stoull(arguments.Flag("seed", "0"))))) {
    said.push_back(worth.rise[static_cast<std::size_t>(i)]);
    truth.push_back(costs.RiseWithout(i));
    if (truth.back() != 0) ratios.push_back(said.back() / truth.back());
  }
  if (ratios.empty()) throw Error(arguments.positional[0] + ": no view shows a Gaussian of it");

  Report report("removals");
  const double correlation = RankCorrelation(said, truth), ratio = Quantile(ratios, 0.5);
  report.Add({{"splat", arguments.positional[0]},
              {"gaussians", static_cast<double>(model.count)},
              {"views", static_cast<double>(judges.views.size())},
              {"removals", static_cast<double>(said.size())},
              {"rank_correlation", correlation},
              {"ratio_10", Quantile(ratios, 0.1)},
              {"ratio_50", ratio},
              {"ratio_90", Quantile(ratios, 0.9)},
              {"better_without", static_cast<double>(std::ranges::count_if(truth, [](double x) { return x < 0; }))}});
  report.AddTarget({"rank correlation of foretold and true rises", correlation, "", 0.9, correlation >= 0.9});
  report.AddTarget({"median ratio of foretold and true rises", ratio, "", 1, ratio >= 0.7 && ratio <= 1.4});
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("removals", vesta::bench::Main, argc, argv); }
