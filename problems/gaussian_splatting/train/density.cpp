#include "problems/gaussian_splatting/train/density.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/train/screen_pull.h"

namespace vesta::gs {
namespace {

constexpr float kSplitShrink = 1.6f;         // children of a split are smaller by this factor
constexpr float kResetLogit = -4.59511985f;  // opacity 0.01

float LargestScale(const SplatModel& model, Index i) {
  float largest = model.attribute(splat::kLogScale)[i];
  for (int k = 1; k < 3; ++k) largest = std::max(largest, model.attribute(splat::kLogScale + k)[i]);
  return std::exp(largest);
}

float Opacity(const SplatModel& model, Index i) { return 1 / (1 + std::exp(-model.attribute(splat::kOpacity)[i])); }

// Two Gaussians in one place, each with this logit, are together as opaque as one was with the given logit
// (Rota Bulo et al. 2024, section 3.2).
float LogitOfEachOfTwo(float logit) {
  // In double: a large logit has no exponential in float.
  const double root = std::sqrt(1 + std::exp(double{logit}));  // 1 / sqrt(1 - opacity)
  return static_cast<float>(std::log(root - 1));
}

// Moves Gaussian i to a sample of the distribution it was, and shrinks it.
void BecomeSample(SplatModel& model, Index i, CounterRandom random) {
  float q[4], R[9];
  for (int k = 0; k < 4; ++k) q[k] = model.attribute(splat::kQuaternion + k)[i];
  RotationFromQuaternion(q, R);
  float offset[3];
  for (int k = 0; k < 3; ++k) {
    float& log_scale = model.attribute(splat::kLogScale + k)[i];
    offset[k] = std::exp(log_scale) * static_cast<float>(random.Normal());
    log_scale -= std::log(kSplitShrink);
  }
  for (int r = 0; r < 3; ++r) {
    model.attribute(splat::kMean + r)[i] += R[3 * r] * offset[0] + R[3 * r + 1] * offset[1] + R[3 * r + 2] * offset[2];
  }
}

}  // namespace

DensityControl::DensityControl(const DensityOptions& options, double extent, std::uint64_t seed, Index count)
    : options_(options), extent_(extent), seed_(seed) {
  Forget(count);
}

void DensityControl::Forget(Index count) {
  pull_.assign(static_cast<std::size_t>(count), 0.0f);
  seen_.assign(static_cast<std::size_t>(count), 0);
}

void DensityControl::Observe(const splat::View<float>& view, const splat::SplatTangent<float>* splat_cotangents,
                             double loss_scale) {
  const auto half_width = static_cast<float>(0.5 * view.pinhole().width / loss_scale);
  const auto half_height = static_cast<float>(0.5 * view.pinhole().height / loss_scale);
  ParallelFor(static_cast<Index>(pull_.size()), 4096, [&](Index i) {
    const std::int32_t rank = view.rank_of()[i];
    if (rank < 0) return;
    pull_[static_cast<std::size_t>(i)] +=
        ScreenPull(view.splats()[rank], splat_cotangents[rank].w, half_width, half_height);
    ++seen_[static_cast<std::size_t>(i)];
  });
}

std::vector<DensityControl::Fate> DensityControl::Decide(const SplatModel& model) const {
  const Index count = model.count;
  std::vector<Fate> fate(static_cast<std::size_t>(count), Fate::kKeep);
  const auto prune_size = static_cast<float>(options_.prune_size * extent_);
  Index kept = 0;
  for (Index i = 0; i < count; ++i) {
    const bool huge = prune_size > 0 && LargestScale(model, i) > prune_size;
    if (huge || Opacity(model, i) < options_.prune_opacity) {
      fate[static_cast<std::size_t>(i)] = Fate::kPrune;
    } else {
      ++kept;
    }
  }
  if (kept == 0) {  // an empty model cannot be trained on: better keep what is there
    std::fill(fate.begin(), fate.end(), Fate::kKeep);
    kept = count;
  }

  struct Candidate {
    float pull;
    Index gaussian;
  };
  std::vector<Candidate> candidates;
  for (Index i = 0; i < count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    if (fate[p] == Fate::kPrune || seen_[p] == 0) continue;
    const float pull = pull_[p] / static_cast<float>(seen_[p]);
    if (pull > options_.gradient_threshold) candidates.push_back({pull, i});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.pull != b.pull ? a.pull > b.pull : a.gaussian < b.gaussian;
  });
  // Each candidate, cloned or split, adds one.
  const Index room = std::max<Index>(options_.max_gaussians - kept, 0);
  if (static_cast<Index>(candidates.size()) > room) candidates.resize(static_cast<std::size_t>(room));
  const auto split_above = static_cast<float>(options_.split_above * extent_);
  for (const Candidate& c : candidates) {
    fate[static_cast<std::size_t>(c.gaussian)] =
        LargestScale(model, c.gaussian) > split_above ? Fate::kSplit : Fate::kClone;
  }
  return fate;
}

void DensityControl::Densify(SplatModel& model, Adam& adam, int iteration) {
  const std::vector<Fate> fate = Decide(model);
  // Those that stay, then the second halves of clones and both halves of splits.
  std::vector<Index> source;
  std::vector<bool> keep_moments;
  for (Index i = 0; i < model.count; ++i) {
    const Fate f = fate[static_cast<std::size_t>(i)];
    if (f == Fate::kKeep || f == Fate::kClone) source.push_back(i), keep_moments.push_back(true);
  }
  for (Index i = 0; i < model.count; ++i) {
    const Fate f = fate[static_cast<std::size_t>(i)];
    for (int copy = f == Fate::kSplit ? 2 : f == Fate::kClone ? 1 : 0; copy > 0; --copy) {
      source.push_back(i), keep_moments.push_back(false);
    }
  }

  model.data = GatherRows(model.data, model.count, model.num_attributes(), source);
  model.count = static_cast<Index>(source.size());
  for (Index i = 0; i < model.count; ++i) {
    switch (fate[static_cast<std::size_t>(source[static_cast<std::size_t>(i)])]) {
      case Fate::kClone: {
        float& logit = model.attribute(splat::kOpacity)[i];
        logit = LogitOfEachOfTwo(logit);
        break;
      }
      case Fate::kSplit:
        BecomeSample(model, i,
                     CounterRandom(seed_, static_cast<std::uint64_t>(iteration), static_cast<std::uint64_t>(i)));
        break;
      default:
        break;
    }
  }
  adam.Rearrange(source, keep_moments, model.num_attributes());
  Forget(model.count);
}

void DensityControl::ResetOpacity(SplatModel& model, Adam& adam) {
  float* logit = model.attribute(splat::kOpacity);
  for (Index i = 0; i < model.count; ++i) logit[i] = std::min(logit[i], kResetLogit);
  adam.Reset(splat::kOpacity);
}

}  // namespace vesta::gs
