#include "problems/gaussian_splatting/train/stage_switch.h"

#include <algorithm>
#include <cmath>

namespace vesta::gs {
namespace {

// Work on one view, in iterations of Adam on it (docs/results/2026-11-22-stage-switch.md).
constexpr double kGradientAndTrial = 1.3;  // of a step: its gradient, and the cost where it leads
constexpr double kGram = 1.3;              // diag(JtJ) and the blocks
constexpr double kProduct = 0.7;           // with JtJ, of a view that is held or whose entries of J are
constexpr double kRebuiltProduct = 1.15;   // of a view that is built anew

constexpr double kWindow = 0.05;  // of the stage, at least: costs of one epoch say little

}  // namespace

double LmWork(const LmStageOptions& lm, Index training_views) {
  const auto all = static_cast<double>(training_views);
  const double views = lm.batch_size > 0 ? std::min(all, double{1} * lm.batches * lm.batch_size) : all;
  const double products = lm.pcg_iterations * (lm.jacobian == JacobianKind::kRebuild ? kRebuiltProduct : kProduct);
  return views * (kGradientAndTrial + kGram + products);
}

StageSwitch::StageSwitch(const TrainOptions& options, Index training_views)
    : adam_(options.adam), end_(options.adam.iterations) {
  const double densification = options.density.enabled ? options.density.end : 0;
  begin_ = static_cast<int>(std::max(adam_.coarse_part, densification) * adam_.iterations) + 1;
  const double epoch = static_cast<double>(training_views) / adam_.views_per_iteration;
  if (adam_.switch_to_lm == SwitchToLm::kAuto && options.lm.iterations > 0) {
    window_ = static_cast<int>(std::ceil(std::max(1.0, std::ceil(kWindow * adam_.iterations / epoch)) * epoch));
  }
  const double work = static_cast<double>(window_) * adam_.views_per_iteration;
  least_fall_ = options.lm.min_gain * work / LmWork(options.lm, training_views);
}

void StageSwitch::Observe(int it, double cost) {
  // Back to an earlier state, for want of memory: what was seen since then counts no more.
  if (it != last_ + 1) Restart();
  last_ = it;
  if (window_ == 0 || end_ < adam_.iterations || it < begin_) return;
  sum_ += cost;
  if (++counted_ < window_) return;
  if (previous_ > 0 && previous_ - sum_ < least_fall_ * previous_) {
    const double end = std::ceil(it / (1 - adam_.cooldown));
    if (end < adam_.iterations) end_ = static_cast<int>(end);
  }
  previous_ = sum_;
  sum_ = 0, counted_ = 0;
}

}  // namespace vesta::gs
