// SPDX-License-Identifier: Apache-2.0
// Adam and density control for host models.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/adam/adam.h"
#include "splatting/density/density.h"

namespace vesta::gs::test {

class ModelAdam {
 public:
  explicit ModelAdam(const LearningRates& rates, SecondMoment metric = SecondMoment::kDiagonal, int views = 1)
      : adam_(rates, metric, views) {}

  void Step(SplatModel& model, float* gradient, int attributes, double factor) {
    layout_ = model;
    adam_.Step(model, {model.data.data(), static_cast<Index>(model.data.size())}, gradient, attributes, factor);
  }
  void SetUnits(const std::vector<float>& units) {
    HostBuffer<float> buffer;
    buffer.CopyFrom({units.data(), static_cast<Index>(units.size())});
    adam_.SetUnits(std::move(buffer));
  }
  void Rearrange(const std::vector<Index>& source, const std::vector<bool>& kept) {
    const std::vector<std::uint32_t> rows(source.begin(), source.end());
    const std::vector<std::uint8_t> flags(kept.begin(), kept.end());
    Rearrange({rows.data(), static_cast<Index>(rows.size())}, {flags.data(), static_cast<Index>(flags.size())});
  }
  void Rearrange(HostSpan<const std::uint32_t> source, HostSpan<const std::uint8_t> kept) {
    const splat::ModelLayout from = layout_;
    layout_ = LayoutOfRows(from, {source.begin(), source.end()});
    adam_.Rearrange(from, layout_, source, kept);
  }
  void Reset(int attribute) { adam_.Reset(layout_, attribute); }
  const Adam<CpuBackend<float>>& adam() const { return adam_; }

 private:
  Adam<CpuBackend<float>> adam_;
  splat::ModelLayout layout_;
};

// Densifies as the Adam stage does. price: GaussianPrice.
inline void Densify(DensityControl<Host>& control, SplatModel& model, ModelAdam& adam, double price) {
  const DensityPlan<Host> plan = control.Decide(model.data.data(), model.count, price);
  if (plan.changes) {
    adam.Rearrange(plan.source, plan.kept);
    model = InOrder(std::move(model), std::vector<Index>(plan.source.begin(), plan.source.end()));
    control.InitChildren(plan, model.data.data());
  }
  control.ResetStatistics(model.count);
}

}  // namespace vesta::gs::test
