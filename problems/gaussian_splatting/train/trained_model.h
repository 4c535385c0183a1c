// A model while Adam trains it, with all that goes with each Gaussian. For every memory space.
#pragma once

#include <utility>
#include <vector>

#include "kernels/gaussian_splatting/project_kernels.h"
#include "problems/gaussian_splatting/adam/adam.h"
#include "problems/gaussian_splatting/adam/parameter_mean.h"
#include "problems/gaussian_splatting/density/density.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

template <class B>
class TrainedModel {
 public:
  using Space = typename B::Space;
  using Vector = typename B::Vector;

  // unit_views: UnitViews; unit: of length, of Gaussians that none of them sees.
  TrainedModel(const SplatModel& model, Adam<B> adam, DensityControl<Space> density,
               const std::vector<splat::PosedCamera>& unit_views, double unit)
      : sh_degree_(model.sh_degree),
        count_(model.count),
        adam_(std::move(adam)),
        density_(std::move(density)),
        unit_(unit) {
    x_.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
    unit_views_.CopyFrom(HostSpan<const splat::PosedCamera>(unit_views.data(), static_cast<Index>(unit_views.size())));
    StartAnew();
  }

  Index count() const { return count_; }
  int sh_degree() const { return sh_degree_; }
  splat::Model<float> kernel_model(int active_sh_degree) const { return AsModel(x_, active_sh_degree); }
  // The mean of the parameters that were averaged, where there is one; else the parameters.
  splat::Model<float> result(int active_sh_degree) const { return AsModel(Result(), active_sh_degree); }
  Adam<B>& adam() { return adam_; }
  DensityControl<Space>& density() { return density_; }
  const Vector& parameters() const { return x_; }

  // For a step on `attributes` of the attributes: zero before the first view's gradient is added, and after Step.
  float* gradient(int attributes) {
    if (gradient_.size() != attributes * count_) gradient_.Resize(attributes * count_);
    return gradient_.data();
  }
  // Of what was added since the last step.
  void ForgetGradient() { gradient_ = Vector(); }
  // Adam's step by the gradient.
  void Step(int attributes, double factor) { adam_.Step(count_, x_, gradient(attributes), attributes, factor); }
  // Counts the parameters in their mean, until Gaussians change. On a device throws OutOfDeviceMemory; then there is no
  // mean.
  void Average() { average_.Add(x_); }

  // Clones, splits and prunes; iteration keys the random offsets of split Gaussians. What was observed is forgotten and
  // units of length are measured anew. before_growth() is called before Gaussians become more, and only then. On a
  // device throws OutOfDeviceMemory: where Gaussians have not become more, what can be downloaded is the model of
  // before or of after.
  template <class BeforeGrowth>
  void Densify(int iteration, const BeforeGrowth& before_growth) {
    average_.StartAnew();
    gradient_ = Vector();  // zero between steps; its room is needed
    const DensityPlan<Space> plan = density_.Decide(x_.data(), count_);
    if (plan.count > count_) before_growth();
    if (plan.changes) Follow(plan, iteration);
    StartAnew();
  }
  // Leaves only these, ascending, with their moments and their mean. On a device throws OutOfDeviceMemory; then what
  // can be downloaded is the model of before.
  void Keep(const std::vector<Index>& kept) {
    gradient_ = Vector();
    const std::vector<std::uint32_t> source(kept.begin(), kept.end());
    const std::vector<std::uint8_t> all(kept.size(), 1);
    Buffer<std::uint32_t, Space> rows;
    Buffer<std::uint8_t, Space> keeping;
    rows.CopyFrom(HostSpan<const std::uint32_t>(source.data(), static_cast<Index>(source.size())));
    keeping.CopyFrom(HostSpan<const std::uint8_t>(all.data(), static_cast<Index>(all.size())));
    ParameterMean<B> average = average_.OfRows(count_, rows);
    Rearrange(rows, keeping);
    average_ = std::move(average);
    StartAnew();
  }
  void ResetOpacity() {
    average_.StartAnew();
    DensityControl<Space>::LowerOpacities(x_.data(), count_);
    adam_.Reset(count_, splat::kOpacity);
  }

  // The parameters of result(), to the host.
  void DownloadResult(SplatModel& model) const { Download(Result(), model); }
  void DownloadParameters(SplatModel& model) const { Download(x_, model); }
  // The same for the last time: frees all else first.
  void Finish(SplatModel& model) {
    gradient_ = Vector();
    adam_.Free();
    DownloadResult(model);
  }
  // Frees all that Visit reads.
  void Free() {
    x_ = Vector(), gradient_ = Vector();
    average_.StartAnew();
    adam_.Free();
    density_.Forget(0);
  }
  // No more Gaussians than there are from now on; what was observed is forgotten.
  void StayAsMany() {
    density_.LimitGaussians(count_);
    StartAnew();
  }

  // Whether what was read is in itself a model that can be trained on.
  bool IsWhole() const {
    // A degree or a count beyond these would overflow the product.
    constexpr Index kMost = Index{1} << 40;
    if (sh_degree_ < 0 || sh_degree_ > 3 || count_ < 1 || count_ > kMost) return false;
    return x_.size() == splat::NumAttributes(sh_degree_) * count_ && adam_.IsOf(count_, x_.size()) &&
           average_.IsOf(x_.size()) && density_.IsOf(count_);
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(sh_degree_, count_, x_, adam_, average_, density_);
    if constexpr (Archive::kReads) gradient_ = Vector();
  }

 private:
  void Follow(const DensityPlan<Space>& plan, int iteration) {
    Rearrange(plan.source, plan.kept);
    density_.Renew(plan, iteration, x_.data());
  }
  // Gaussian i becomes a copy of source[i], with its moments where kept[i].
  void Rearrange(const Buffer<std::uint32_t, Space>& source, const Buffer<std::uint8_t, Space>& kept) {
    adam_.Rearrange(count_, source, kept);
    const Index attributes = splat::NumAttributes(sh_degree_), count = source.size();
    Vector x;
    x.ResizeForOverwrite(attributes * count);
    GatherRows<Space>(
        RowGathering<std::uint32_t>{attributes, count_, count, source.data(), nullptr, x_.data(), x.data()});
    x_ = std::move(x);
    count_ = count;
  }
  // What begins anew with each change of the model.
  void StartAnew() {
    density_.Forget(count_);
    adam_.SetUnits(MeasureUnits<Space>(count_, x_.data(), unit_views_, unit_));
  }
  void Download(const Vector& x, SplatModel& model) const {
    model.sh_degree = sh_degree_;
    model.count = count_;
    model.data.resize(static_cast<std::size_t>(x.size()));
    B().ToHost(x.view(), {model.data.data(), x.size()});
  }
  const Vector& Result() const { return average_.empty() ? x_ : average_.value(); }
  splat::Model<float> AsModel(const Vector& x, int active_sh_degree) const {
    return {x.data(), count_, sh_degree_, active_sh_degree};
  }

  int sh_degree_;
  Index count_;
  Adam<B> adam_;
  DensityControl<Space> density_;
  Vector x_, gradient_;
  ParameterMean<B> average_;
  Buffer<splat::PosedCamera, Space> unit_views_;
  double unit_;
};

}  // namespace vesta::gs
