// SPDX-License-Identifier: Apache-2.0
#include "bench/growth/mcmc.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/growth/bare_stage.h"
#include "kernels/core/random.h"
#include "kernels/math/quaternion.h"

namespace vesta::bench {
namespace {

constexpr int kMostCopies = 51;

double Sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

class Mcmc {
 public:
  Mcmc(const gs::Scene& scene, const gs::TrainOptions& options, const McmcOptions& mcmc)
      : options_(Limited(options, mcmc.gaussians)), mcmc_(mcmc), extent_(scene.extent), stage_(scene, options_) {
    const double rounds = std::max(1.0, (0.5 - mcmc_.begin) * stage_.iterations() / mcmc_.every);
    const double missing = static_cast<double>(mcmc_.gaussians) / static_cast<double>(stage_.model().count());
    growth_ = std::max(1 + mcmc_.growth, std::pow(missing, 1 / rounds));
  }

  McmcResult Train() {
    while (stage_.done() < stage_.iterations()) {
      const gs::IterationPlan plan = stage_.NextPlan();
      AddPenalties(plan);
      stage_.Step(plan);
      if (stage_.session().schedule().Averages(plan.span, stage_.done())) {
        stage_.model().Average();
      } else if (plan.span.IsWithin(1 - options_.adam.averaging_fraction)) {
        AddNoise(plan.lr_factor);
      }
      const bool relocates = plan.span.HasReached(mcmc_.begin) && plan.span.IsWithin(mcmc_.end);
      if (relocates && stage_.done() % mcmc_.every == 0) Relocate();
    }
    return {stage_.Evaluate(), stage_.model().count()};
  }

 private:
  const float* Row(int attribute) { return stage_.model().parameters().data() + attribute * stage_.model().count(); }
  double OpacityOf(Index i) { return Sigmoid(Row(splat::kOpacity)[i]); }

  // To the gradient of the loss, which is summed over pixels and channels.
  void AddPenalties(const gs::IterationPlan& plan) {
    gs::TrainedModel<BareStage::Cpu>& model = stage_.model();
    const Index n = model.count();
    float* const gradient = model.gradient(stage_.Attributes(plan));
    const double values = stage_.ValuesOf(plan) / static_cast<double>(n);
    for (Index i = 0; i < n; ++i) {
      const double opacity = OpacityOf(i);
      gradient[splat::kOpacity * n + i] += static_cast<float>(mcmc_.opacity_penalty * values * opacity * (1 - opacity));
      for (int k = 0; k < 3; ++k) {
        const double scale = std::exp(Row(splat::kLogScale + k)[i]) / extent_;
        gradient[(splat::kLogScale + k) * n + i] += static_cast<float>(mcmc_.scale_penalty * values * scale / 3);
      }
    }
  }

  // Moves each mean by noise with the Gaussian's covariance, much less where opaque (equation 8).
  void AddNoise(double lr_factor) {
    gs::TrainedModel<BareStage::Cpu>& model = stage_.model();
    const Index n = model.count();
    const double size = mcmc_.noise * options_.lr.position * lr_factor / extent_;
    std::vector<float> means(Row(splat::kMean), Row(splat::kMean) + 3 * n);
    for (Index i = 0; i < n; ++i) {
      const double gate = size * Sigmoid(-100 * (OpacityOf(i) - mcmc_.min_opacity));
      if (gate < 1e-9 * size) continue;
      CounterRandom random(options_.seed, static_cast<std::uint64_t>(stage_.done()), static_cast<std::uint64_t>(i));
      float q[4], R[9];
      for (int k = 0; k < 4; ++k) q[k] = Row(splat::kQuaternion + k)[i];
      RotationFromQuaternion(q, R);
      double along[3];  // in the axes of the Gaussian
      double noise[3];
      for (double& one : noise) one = random.Normal();
      for (int k = 0; k < 3; ++k) {
        const double scale = std::exp(Row(splat::kLogScale + k)[i]);
        along[k] = 0;
        for (int r = 0; r < 3; ++r) along[k] += scale * scale * R[3 * r + k] * noise[r];
      }
      for (int r = 0; r < 3; ++r) {
        double step = 0;
        for (int k = 0; k < 3; ++k) step += R[3 * r + k] * along[k];
        means[static_cast<std::size_t>(r * n + i)] += static_cast<float>(gate * step);
      }
    }
    for (int r = 0; r < 3; ++r) {
      const auto begin = means.begin() + r * n;
      model.SetAttribute(splat::kMean + r, {begin, begin + n});
    }
  }

  // Gaussians of low opacity, and new ones, become copies of others, which are drawn by opacity.
  void Relocate() {
    gs::TrainedModel<BareStage::Cpu>& model = stage_.model();
    const Index n = model.count();
    std::vector<std::uint32_t> source;
    std::vector<Index> moved;
    std::vector<double> sums;  // of the opacities of the living up to Gaussian i
    for (Index i = 0; i < n; ++i) {
      const bool is_dead = OpacityOf(i) <= mcmc_.min_opacity;
      sums.push_back((i > 0 ? sums.back() : 0) + (is_dead ? 0 : OpacityOf(i)));
      source.push_back(static_cast<std::uint32_t>(i));
      if (is_dead) moved.push_back(i);
    }
    if (sums.empty() || sums.back() <= 0) return;
    const auto grown = static_cast<Index>(std::ceil(growth_ * static_cast<double>(n)));
    for (Index i = n; i < std::min(grown, std::max(n, mcmc_.gaussians)); ++i) {
      source.push_back(0);
      moved.push_back(i);
    }
    CounterRandom random(options_.seed, static_cast<std::uint64_t>(stage_.done()), ~std::uint64_t{0});
    std::vector<int> copies(static_cast<std::size_t>(n), 1);
    for (const Index i : moved) {
      const auto drawn = std::upper_bound(sums.begin(), sums.end(), random.Uniform() * sums.back()) - sums.begin();
      source[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(drawn);
      ++copies[static_cast<std::size_t>(drawn)];
    }
    Copy(source, copies);
  }
  void Copy(const std::vector<std::uint32_t>& source, const std::vector<int>& copies) {
    gs::TrainedModel<BareStage::Cpu>& model = stage_.model();
    const auto after = static_cast<Index>(source.size());
    HostBuffer<std::uint32_t> from;
    HostBuffer<std::uint8_t> kept;
    from.CopyFrom(HostSpan<const std::uint32_t>(source.data(), after));
    kept.Resize(after);
    for (Index i = 0; i < after; ++i) kept[i] = copies[from[i]] == 1 ? 1 : 0;
    model.Replace(from, kept);
    std::vector<float> values[4];
    for (int a = 0; a < 4; ++a) {
      const float* row = Row(a < 3 ? splat::kLogScale + a : splat::kOpacity);
      values[a].assign(row, row + after);
    }
    for (std::size_t i = 0; i < source.size(); ++i) {
      const int number = copies[source[i]];
      if (number == 1) continue;
      const SharedShape shape = ShapeOfCopies(Sigmoid(values[3][i]), std::min(number, kMostCopies));
      for (int k = 0; k < 3; ++k) values[k][i] += static_cast<float>(std::log(shape.scale));
      const double opacity = std::clamp(shape.opacity, mcmc_.min_opacity, 1 - 1e-6);
      values[3][i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    }
    for (int a = 0; a < 4; ++a) model.SetAttribute(a < 3 ? splat::kLogScale + a : splat::kOpacity, values[a]);
  }

  // Not more points at the start than Gaussians at the end.
  static gs::TrainOptions Limited(gs::TrainOptions options, Index gaussians) {
    options.density.max_gaussians = std::min(options.density.max_gaussians, gaussians);
    return options;
  }

  const gs::TrainOptions options_;
  const McmcOptions& mcmc_;
  double extent_;
  BareStage stage_;
  double growth_;
};

}  // namespace

SharedShape ShapeOfCopies(double opacity, int copies) {
  const double shared = 1 - std::pow(1 - opacity, 1.0 / copies);
  double sum = 0;
  for (int i = 1; i <= copies; ++i) {
    double term = shared;  // binomial(i - 1, k) (-shared)^k shared
    for (int k = 0; k < i; ++k) {
      sum += term / std::sqrt(k + 1.0);
      term *= -shared * (i - 1 - k) / (k + 1);
    }
  }
  return {shared, opacity / sum};
}

McmcResult TrainByMcmc(const gs::Scene& scene, const gs::TrainOptions& options, const McmcOptions& mcmc) {
  return Mcmc(scene, options, mcmc).Train();
}

}  // namespace vesta::bench
