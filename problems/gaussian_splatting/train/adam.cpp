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

float Adam::StepRate(int attribute, double factor, int steps) const {
  const double correction1 = 1 - std::pow(double{kAdamBeta1}, steps);
  return static_cast<float>(RateOf(rates_, attribute) * factor / correction1);
}

float Adam::RootCorrection2(int steps) {
  return static_cast<float>(1 / std::sqrt(1 - std::pow(double{kAdamBeta2}, steps)));
}

void Adam::Step(SplatModel& model, float* gradient, int num_attributes, double factor) {
  if (first_.empty()) {
    count_ = model.count;
    first_.assign(model.data.size(), 0.0f);
    second_.assign(model.data.size(), 0.0f);
  }
  VESTA_CHECK(units_.empty() || static_cast<Index>(units_.size()) == model.count, "{} units of length for {} Gaussians",
              units_.size(), model.count);
  ++steps_;
  const AdamUpdate update = AdamUpdateFor(ActiveIsa());
  const Index count = model.count;
  constexpr Index kGrain = 4096;
  const Index chunks = (count + kGrain - 1) / kGrain;
  ParallelFor(chunks * num_attributes, 1, [&](Index task) {
    const auto attribute = static_cast<int>(task / chunks);
    const Index begin = task % chunks * kGrain, n = std::min(kGrain, count - begin);
    const Index offset = attribute * count + begin;
    update({.size = n,
            .gradient = gradient + offset,
            .parameters = model.data.data() + offset,
            .first = first_.data() + offset,
            .second = second_.data() + offset,
            .units = attribute < splat::kLogScale && !units_.empty() ? units_.data() + begin : nullptr,
            .rate = StepRate(attribute, factor, steps_),
            .root_correction2 = RootCorrection2(steps_)});
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
}

void Adam::Reset(int attribute) {
  if (first_.empty()) return;
  for (std::vector<float>* moments : {&first_, &second_}) {
    std::fill_n(moments->begin() + attribute * count_, count_, 0.0f);
  }
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
