#include "bench/foretold/experiments.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/random.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/engine_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/model/spatial_order.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "problems/gaussian_splatting/parsimony/harmonics.h"
#include "problems/gaussian_splatting/parsimony/worth.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {
namespace {

// The first `most` of them in an order by chance.
std::vector<Index> Draw(std::vector<Index> from, std::size_t most, CounterRandom& random) {
  most = std::min(from.size(), most);
  for (std::size_t k = 0; k < most; ++k) {
    std::swap(from[k], from[k + static_cast<std::size_t>(random.Below(static_cast<Index>(from.size() - k)))]);
  }
  from.resize(most);
  return from;
}

// Those that have a share of some pixel.
std::vector<Index> Seen(const gs::Worth& worth) {
  std::vector<Index> seen;
  for (std::size_t i = 0; i < worth.weight.size(); ++i) {
    if (worth.weight[i] > 0) seen.push_back(static_cast<Index>(i));
  }
  if (seen.empty()) Fail("no view shows a Gaussian of the splat");
  return seen;
}

// The judges' cost if their images were linear in the parameters.
double CostAfter(const gs::JudgingViews& judges, const gs::SplatModel& model, const std::vector<float>& step) {
  const splat::Model<float> x = gs::ToKernelModel(model);
  splat::SplatView<float> splats;
  splat::ViewWorkspace<float> workspace;
  PhotometricLoss<float> loss;
  HostBuffer<float> image, change;
  double cost = 0;
  for (const gs::View* view : judges.views) {
    const ImageShape shape{view->camera.width, view->camera.height};
    image.ResizeForOverwrite(shape.NumValues());
    change.ResizeForOverwrite(shape.NumValues());
    splats.Build(x, gs::ToPosedCamera(*view, judges.near), judges.background.data(), workspace);
    splats.RenderAndApplyJ(x, step.data(), image.data(), change.data(), workspace);
    for (Index k = 0; k < shape.NumValues(); ++k) image[k] += change[k];
    cost += loss.Evaluate(image, {view->image.rgb.data(), shape.NumValues()}, shape).objective;
  }
  return cost;
}

// One step from the model, all its Gaussians at once.
std::vector<float> Step(const gs::JudgingViews& judges, double extent, const gs::SplatModel& model) {
  using B = CpuBackend<float>;
  gs::LmStageOptions lm;
  lm.iterations = 1, lm.pcg_iterations = 10;
  gs::SplatProblemOptions options;
  static_cast<gs::SplatMetricOptions&>(options) = lm;
  options.sh_degree = model.sh_degree;
  options.count = model.count;
  options.background = judges.background;
  options.jacobian = lm.jacobian;
  options.units = std::make_shared<const std::vector<float>>(gs::LengthUnits(model, judges.views, judges.near, extent));
  std::vector<gs::TargetView<B>> views;
  views.reserve(judges.views.size());
  for (const gs::View* view : judges.views) {
    views.push_back(
        {gs::ToPosedCamera(*view, judges.near), {view->image.rgb.data(), static_cast<Index>(view->image.rgb.size())}});
  }
  gs::SplatProblem<B> problem(options, views);
  B backend;
  B::Vector x;
  x.ResizeForOverwrite(static_cast<Index>(model.data.size()));
  std::ranges::copy(model.data, x.data());
  SolveLm<B>(gs::LmEngineOptions(lm), backend, problem, x.view());
  std::vector<float> step(x.begin(), x.end());
  for (std::size_t k = 0; k < step.size(); ++k) step[k] -= model.data[k];
  return step;
}

}  // namespace

Foretold RemoveGaussians(JudgedModel& judged, int count, std::uint64_t seed) {
  const gs::Worth worth = gs::MeasureWorth(gs::ToKernelModel(judged.model()), judged.judges());
  CounterRandom random(seed, 0);
  Foretold result;
  for (const Index i : Draw(Seen(worth), static_cast<std::size_t>(count), random)) {
    constexpr float kNone = -100;
    result.said.push_back(worth.rise[static_cast<std::size_t>(i)]);
    result.truth.push_back(
        judged.RiseOf(i, [&](gs::SplatModel& model) { model.attribute(splat::kOpacity)[i] = kNone; }));
  }
  return result;
}

Foretold LowerDegrees(JudgedModel& judged, int count, std::uint64_t seed) {
  if (judged.model().sh_degree == 0) Fail("the splat has no degree of the harmonics that could be lowered");
  const splat::Model<float> kernel_model = gs::ToKernelModel(judged.model());
  const gs::HarmonicsWorth worth(kernel_model, judged.judges());
  CounterRandom random(seed, 0);
  Foretold result;
  for (const Index i :
       Draw(Seen(gs::MeasureWorth(kernel_model, judged.judges())), static_cast<std::size_t>(count), random)) {
    const int degree = static_cast<int>(random.Below(judged.model().sh_degree));
    result.said.push_back(worth.Rise(i, degree));
    result.truth.push_back(judged.RiseOf(i, [&](gs::SplatModel& model) {
      for (int a = 0; a < model.num_attributes() - splat::kSh; ++a) {
        model.attribute(splat::kSh + a)[i] = a < 3 * ShCoefficients(degree) ? worth.Coefficient(i, degree, a) : 0;
      }
    }));
  }
  return result;
}

Foretold RemoveBatches(JudgedModel& judged, double extent, std::uint64_t seed) {
  constexpr std::size_t kParts = 10;
  const gs::Worth worth = gs::MeasureWorth(gs::ToKernelModel(judged.model()), judged.judges());
  const auto all = static_cast<std::size_t>(judged.model().count);
  std::vector<Index> order(all);
  std::iota(order.begin(), order.end(), Index{0});
  std::vector<std::vector<Index>> batches;
  CounterRandom random(seed, 0);
  for (std::size_t k = 0; k < kParts; ++k) batches.push_back(Draw(order, all / kParts, random));
  std::ranges::sort(order, [&](Index a, Index b) {
    return worth.rise[static_cast<std::size_t>(a)] < worth.rise[static_cast<std::size_t>(b)];
  });
  for (std::size_t k = 0; k < kParts; ++k) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(k * all / kParts);
    batches.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(all / kParts));
  }
  Foretold result;
  for (const std::vector<Index>& batch : batches) {
    std::vector<char> goes(all);
    for (const Index i : batch) goes[static_cast<std::size_t>(i)] = 1;
    std::vector<Index> kept;
    for (std::size_t i = 0; i < all; ++i) {
      if (goes[i] == 0) kept.push_back(static_cast<Index>(i));
    }
    gs::SplatModel model = gs::InOrder(judged.model(), kept);
    const double at_once = judged.CostOf(model) - judged.cost();
    const std::vector<float> step = Step(judged.judges(), extent, model);
    result.said.push_back(CostAfter(judged.judges(), model, step) - judged.cost());
    for (std::size_t k = 0; k < step.size(); ++k) model.data[k] += step[k];
    result.truth.push_back(judged.CostOf(model) - judged.cost());
    fmt::print(stderr, "at once {:.4f}, foretold {:.4f}, true {:.4f} of the cost\n", at_once / judged.cost(),
               result.said.back() / judged.cost(), result.truth.back() / judged.cost());
  }
  return result;
}

}  // namespace vesta::bench
