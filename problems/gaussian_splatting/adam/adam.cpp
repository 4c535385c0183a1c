#include "problems/gaussian_splatting/adam/adam.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/adam/adam_kernel.h"
#include "problems/gaussian_splatting/model/gather_rows.h"

namespace vesta::gs {

AdamMetric MetricOf(const AdamOptions& options) {
  return options.metric == "block" ? AdamMetric::kBlock : AdamMetric::kDiagonal;
}

float Adam::StepFactor(double factor, int steps) {
  return static_cast<float>(factor / (1 - std::pow(double{kAdamBeta1}, steps)));
}

float Adam::StepRate(int attribute, double factor, int steps) const {
  return static_cast<float>(RateOf(rates_, attribute) * StepFactor(factor, steps));
}

float Adam::RootCorrection2(int steps) {
  return static_cast<float>(1 / std::sqrt(1 - std::pow(double{kAdamBeta2}, steps)));
}

BlockAdamArrays Adam::BlockRates(double factor, int steps) const {
  BlockAdamArrays arrays{};
  for (int k = 0; k < kBlockSize; ++k) arrays.rates[k] = static_cast<float>(RateOf(rates_, k));
  arrays.step = StepFactor(factor, steps);
  arrays.root_correction2 = RootCorrection2(steps);
  return arrays;
}

void Adam::Start(const SplatModel& model) {
  count_ = model.count;
  moments_.first.assign(model.data.size(), 0.0f);
  moments_.second.assign(model.data.size(), 0.0f);
  if (blocks_) moments_.bases = BlockBases(count_);
}

AdamMoments Adam::TakeMoments() { return std::exchange(moments_, {}); }

void Adam::SetMoments(Index count, AdamMoments moments) {
  count_ = count;
  moments_ = std::move(moments);
}

int Adam::first_diagonal() const { return blocks_ ? kBlockSize : 0; }

void Adam::Step(SplatModel& model, float* gradient, int num_attributes, double factor) {
  const Index count = model.count;
  if (moments_.first.empty()) Start(model);
  VESTA_CHECK(units_.empty() || static_cast<Index>(units_.size()) == count, "{} units of length for {} Gaussians",
              units_.size(), count);
  ++steps_;
  BlockAdamArrays blocks = BlockRates(factor, steps_);
  blocks.count = count;
  blocks.gradient = gradient;
  blocks.parameters = model.data.data();
  blocks.first = moments_.first.data();
  blocks.second = moments_.second.data();
  blocks.units = units_.empty() ? nullptr : units_.data();
  float rates[splat::kMaxAttributes];
  for (int a = 0; a < num_attributes; ++a) rates[a] = StepRate(a, factor, steps_);
  const AdamKernels kernels = AdamKernelsFor(ActiveIsa());
  ParallelFor((count + kTurnChunk - 1) / kTurnChunk, 1, [&](Index chunk) {
    const Index begin = chunk * kTurnChunk, end = std::min(begin + kTurnChunk, count);
    if (blocks_) {
      BlockAdamArrays piece = blocks;
      piece.bases = moments_.bases.piece(chunk);
      piece.bases_begin = begin;
      kernels.step_blocks(piece, begin, end);
      if (chunk % kTurnEvery == FirstTurned(steps_)) kernels.turn_bases(piece, begin, end);
    }
    for (int a = first_diagonal(); a < num_attributes; ++a) {
      const Index offset = a * count + begin;
      kernels.step({.size = end - begin,
                    .gradient = gradient + offset,
                    .parameters = model.data.data() + offset,
                    .first = moments_.first.data() + offset,
                    .second = moments_.second.data() + offset,
                    .units = a < splat::kLogScale && blocks.units ? blocks.units + begin : nullptr,
                    .rate = rates[a],
                    .root_correction2 = blocks.root_correction2});
    }
  });
}

void Adam::Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep, int num_attributes) {
  if (moments_.first.empty()) return;
  const auto count = static_cast<Index>(source.size());
  for (std::vector<float>* moments : {&moments_.first, &moments_.second}) {
    *moments = GatherRows(*moments, count_, num_attributes, source);
    for (Index i = 0; i < count; ++i) {
      if (keep[static_cast<std::size_t>(i)]) continue;
      for (int a = 0; a < num_attributes; ++a) (*moments)[static_cast<std::size_t>(a * count + i)] = 0;
    }
  }
  count_ = count;
  if (blocks_) moments_.bases.Rearrange(source, keep);
}

void Adam::Reset(int attribute) {
  if (moments_.first.empty()) return;
  std::fill_n(moments_.first.begin() + attribute * count_, count_, 0.0f);
  // Of a block the second moments are those of directions, not of attributes: they stay.
  if (attribute >= first_diagonal()) std::fill_n(moments_.second.begin() + attribute * count_, count_, 0.0f);
}

}  // namespace vesta::gs
