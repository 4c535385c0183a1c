#include "problems/gaussian_splatting/train/adam.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/train/adam_kernel.h"

namespace vesta::gs {

double RateOf(const LearningRates& rates, int attribute) {
  if (attribute < splat::kLogScale) return rates.position;
  if (attribute < splat::kQuaternion) return rates.log_scale;
  if (attribute < splat::kOpacity) return rates.quaternion;
  if (attribute < splat::kSh) return rates.opacity;
  return attribute < splat::kSh + 3 ? rates.sh_dc : rates.sh_rest;
}

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
  first_.assign(model.data.size(), 0.0f);
  second_.assign(model.data.size(), 0.0f);
  if (!blocks_) return;
  bases_.assign(static_cast<std::size_t>(BlockArraySize(count_)), 0.0f);
  for (Index i = 0; i < count_; ++i) {
    for (int k = 0; k < kBlockSize; ++k) bases_[static_cast<std::size_t>(BlockEntry((kBlockSize + 1) * k, i))] = 1;
  }
}

void Adam::ReleaseMoments() {
  for (std::vector<float>* values : {&first_, &second_, &bases_}) *values = std::vector<float>();
}

void Adam::SetMoments(Index count, std::vector<float> first, std::vector<float> second, std::vector<float> bases) {
  count_ = count;
  first_ = std::move(first);
  second_ = std::move(second);
  bases_ = std::move(bases);
}

int Adam::first_diagonal() const { return blocks_ ? kBlockSize : 0; }

void Adam::Step(SplatModel& model, float* gradient, int num_attributes, double factor) {
  if (first_.empty()) Start(model);
  VESTA_CHECK(units_.empty() || static_cast<Index>(units_.size()) == model.count, "{} units of length for {} Gaussians",
              units_.size(), model.count);
  ++steps_;
  if (blocks_) StepBlocks(model, gradient, factor);
  const int begin_attribute = first_diagonal();
  const AdamKernels kernels = AdamKernelsFor(ActiveIsa());
  const Index count = model.count;
  constexpr Index kGrain = 4096;
  const Index chunks = (count + kGrain - 1) / kGrain;
  ParallelFor(chunks * (num_attributes - begin_attribute), 1, [&](Index task) {
    const int attribute = begin_attribute + static_cast<int>(task / chunks);
    const Index begin = task % chunks * kGrain, n = std::min(kGrain, count - begin);
    const Index offset = attribute * count + begin;
    kernels.step({.size = n,
                  .gradient = gradient + offset,
                  .parameters = model.data.data() + offset,
                  .first = first_.data() + offset,
                  .second = second_.data() + offset,
                  .units = attribute < splat::kLogScale && !units_.empty() ? units_.data() + begin : nullptr,
                  .rate = StepRate(attribute, factor, steps_),
                  .root_correction2 = RootCorrection2(steps_)});
  });
}

void Adam::StepBlocks(SplatModel& model, float* gradient, double factor) {
  BlockAdamArrays arrays = BlockRates(factor, steps_);
  arrays.count = model.count;
  arrays.gradient = gradient;
  arrays.parameters = model.data.data();
  arrays.first = first_.data();
  arrays.second = second_.data();
  arrays.bases = bases_.data();
  arrays.units = units_.empty() ? nullptr : units_.data();
  const AdamKernels kernels = AdamKernelsFor(ActiveIsa());
  ParallelFor((model.count + kTurnChunk - 1) / kTurnChunk, 1, [&](Index chunk) {
    const Index begin = chunk * kTurnChunk, end = std::min(begin + kTurnChunk, model.count);
    kernels.step_blocks(arrays, begin, end);
    if (chunk % kTurnEvery == FirstTurned(steps_)) kernels.turn_bases(arrays, begin, end);
  });
}

void Adam::Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep, int num_attributes) {
  if (first_.empty()) return;
  const auto count = static_cast<Index>(source.size());
  for (std::vector<float>* moments : {&first_, &second_}) {
    *moments = GatherRows(*moments, count_, num_attributes, source);
    for (Index i = 0; i < count; ++i) {
      if (keep[static_cast<std::size_t>(i)]) continue;
      for (int a = 0; a < num_attributes; ++a) (*moments)[static_cast<std::size_t>(a * count + i)] = 0;
    }
  }
  count_ = count;
  if (!blocks_) return;
  std::vector<float> bases(static_cast<std::size_t>(BlockArraySize(count)));
  ParallelFor(count, 1024, [&](Index i) {
    const Index from = source[static_cast<std::size_t>(i)];
    // New Gaussians keep the directions of those that they come from.
    const int numbers = keep[static_cast<std::size_t>(i)] ? kBlockNumbers : kBasisSize;
    for (int k = 0; k < numbers; ++k) {
      bases[static_cast<std::size_t>(BlockEntry(k, i))] = bases_[static_cast<std::size_t>(BlockEntry(k, from))];
    }
  });
  bases_ = std::move(bases);
}

void Adam::Reset(int attribute) {
  if (first_.empty()) return;
  std::fill_n(first_.begin() + attribute * count_, count_, 0.0f);
  // Of a block the second moments are those of directions, not of attributes: they stay.
  if (attribute >= first_diagonal()) std::fill_n(second_.begin() + attribute * count_, count_, 0.0f);
}

std::vector<float> GatherRows(const std::vector<float>& data, Index count, int attributes,
                              const std::vector<Index>& source) {
  const auto rows = static_cast<Index>(source.size());
  std::vector<float> result(static_cast<std::size_t>(rows * attributes));
  ParallelFor(attributes, 1, [&](Index a) {
    const float* from = data.data() + a * count;
    float* to = result.data() + a * rows;
    for (Index i = 0; i < rows; ++i) to[i] = from[source[static_cast<std::size_t>(i)]];
  });
  return result;
}

}  // namespace vesta::gs
