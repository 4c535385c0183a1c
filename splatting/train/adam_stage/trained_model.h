// SPDX-License-Identifier: Apache-2.0
// The model while the Adam stage trains it, and the whole state that the stage resumes from.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/gather_rows.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/adam/adam.h"
#include "splatting/adam/parameter_mean.h"
#include "splatting/adam/view_order.h"
#include "splatting/density/density.h"
#include "splatting/train/adam_stage/stage_cameras.h"

namespace vesta::gs {

// A model while Adam trains it, with all that goes with each Gaussian. For every memory space.
template <class B>
class TrainedModel {
 public:
  using Space = typename B::Space;
  using Vector = typename B::Vector;

  // unit_views: UnitViews; unit: of length, of Gaussians that none of them sees.
  TrainedModel(const SplatModel& model, Adam<B> adam, DensityControl<Space> density,
               const std::vector<splat::PosedCamera>& unit_views, double unit)
      : layout_(model), adam_(std::move(adam)), density_(std::move(density)), unit_(unit) {
    x_.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
    unit_views_.CopyFrom(HostSpan<const splat::PosedCamera>(unit_views.data(), static_cast<Index>(unit_views.size())));
    StartAnew();
  }

  const splat::ModelLayout& layout() const { return layout_; }
  Index count() const { return layout_.count; }
  int sh_degree() const { return layout_.sh_degree; }
  splat::Model<float> kernel_model(int active_sh_degree) const { return AsModel(x_, active_sh_degree); }
  // The mean of the parameters that were averaged, where there is one; else the parameters.
  splat::Model<float> result(int active_sh_degree) const { return AsModel(Result(), active_sh_degree); }
  Adam<B>& adam() { return adam_; }
  DensityControl<Space>& density() { return density_; }
  const Vector& parameters() const { return x_; }

  // For a step on `attributes` of the attributes: zero before the first view's gradient is added, and after Step.
  float* gradient(int attributes) {
    if (gradient_.size() != layout_.Offset(attributes)) gradient_.Resize(layout_.Offset(attributes));
    return gradient_.data();
  }
  // Of what was added since the last step.
  void ForgetGradient() { gradient_ = Vector(); }
  // Adam's step by the gradient.
  void Step(int attributes, double factor) { adam_.Step(layout_, x_, gradient(attributes), attributes, factor); }
  // Counts the parameters in their mean, until Gaussians change. On a device throws OutOfDeviceMemory; then there is no
  // mean.
  void Average() { average_.Add(x_); }

  // Clones, splits and prunes; iteration keys the random offsets of split Gaussians. What was observed is forgotten and
  // units of length are measured anew. rollback_point() is called before Gaussians become more, and only then. On a
  // device throws OutOfDeviceMemory: where Gaussians have not become more, what can be downloaded is the model of
  // before or of after.
  template <class RollbackPoint>
  void Densify(int iteration, const RollbackPoint& rollback_point) {
    average_.StartAnew();
    gradient_ = Vector();  // zero between steps; its room is needed
    const DensityPlan<Space> plan = density_.Decide(x_.data(), count());
    if (plan.count > count()) rollback_point();
    if (plan.changes) Follow(plan, iteration);
    StartAnew();
  }
  // Leaves only these, ascending, with their moments and their mean. On a device throws OutOfDeviceMemory; then what
  // can be downloaded is the model of before.
  void Keep(const std::vector<Index>& kept) {
    const std::vector<std::uint32_t> source(kept.begin(), kept.end());
    Take({source, LayoutOfRows(layout_, source)});
    StartAnew();
  }
  // Gives each Gaussian a degree, none above the one it has: the bands above are gone, with their moments and mean. The
  // order changes (OrderByDegree), and with it all else that goes with a Gaussian. On a device throws
  // OutOfDeviceMemory; then what can be downloaded is the model of before or of after.
  void SetDegrees(const std::vector<std::uint8_t>& degrees) {
    const DegreeOrder order = OrderByDegree(layout_, degrees);
    if (order.layout == layout_) return;
    const Buffer<std::uint32_t, Space> rows = Take(order);
    density_.Reorder(rows);
    adam_.SetUnits(GatherNumbers(adam_.units(), rows));
  }
  // One attribute of the Gaussians that have it; their mean begins anew.
  void SetAttribute(int attribute, const std::vector<float>& values) {
    average_.StartAnew();
    const Index rows = layout_.Rows(attribute);
    B().FromHost({values.data(), rows}, x_.view().subspan(layout_.Offset(attribute), rows));
  }
  void ResetOpacity() {
    average_.StartAnew();
    DensityControl<Space>::LowerOpacities(x_.data(), count());
    adam_.Reset(layout_, splat::kOpacity);
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
    density_.LimitGaussians(count());
    StartAnew();
  }

  // Whether what was read is in itself a model that can be trained on.
  bool IsWhole() const {
    return layout_.IsOfModel() && x_.size() == layout_.Size() && adam_.IsOf(count(), x_.size()) &&
           average_.IsOf(x_.size()) && density_.IsOf(count());
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(layout_, x_, adam_, average_, density_);
    if constexpr (Archive::kReads) gradient_ = Vector();
  }

 private:
  void Follow(const DensityPlan<Space>& plan, int iteration) {
    Rearrange(LayoutOf(plan.source), plan.source, plan.kept);
    density_.Renew(plan, iteration, x_.data());
  }
  // Of Gaussians whose sources are in the order of their degrees.
  splat::ModelLayout LayoutOf(const Buffer<std::uint32_t, Space>& source) const {
    if (layout_.is_uniform()) return {.count = source.size(), .sh_degree = sh_degree()};
    return LayoutOfRows(layout_, OnHost(source));
  }
  static std::vector<std::uint32_t> OnHost(const Buffer<std::uint32_t, Space>& rows) {
    if constexpr (std::is_same_v<Space, Host>) {
      return {rows.begin(), rows.end()};
    } else {
      std::vector<std::uint32_t> copy(static_cast<std::size_t>(rows.size()));
      rows.CopyTo({copy.data(), rows.size()});
      return copy;
    }
  }
  // Leaves what the order takes, with its moments and its mean. Returns the sources.
  Buffer<std::uint32_t, Space> Take(const DegreeOrder& order) {
    gradient_ = Vector();
    const std::vector<std::uint8_t> all(order.source.size(), 1);
    Buffer<std::uint32_t, Space> rows;
    Buffer<std::uint8_t, Space> keeping;
    rows.CopyFrom(HostSpan<const std::uint32_t>(order.source.data(), order.layout.count));
    keeping.CopyFrom(HostSpan<const std::uint8_t>(all.data(), order.layout.count));
    ParameterMean<B> average = average_.OfRows(layout_, order.layout, rows);
    Rearrange(order.layout, rows, keeping);
    average_ = std::move(average);
    return rows;
  }
  // Gaussian i becomes a copy of source[i], as far as `layout` has its bands, with its moments where kept[i].
  void Rearrange(const splat::ModelLayout& layout, const Buffer<std::uint32_t, Space>& source,
                 const Buffer<std::uint8_t, Space>& kept) {
    adam_.Rearrange(layout_, layout, source, kept);
    Vector x;
    x.ResizeForOverwrite(layout.Size());
    GatherGaussians<Space>(layout_, layout, source.data(), nullptr, x_.data(), x.data());
    x_ = std::move(x);
    layout_ = layout;
  }
  // What begins anew with each change of the model.
  void StartAnew() {
    density_.Forget(count());
    adam_.SetUnits(MeasureUnits<Space>(count(), x_.data(), unit_views_, unit_));
  }
  void Download(const Vector& x, SplatModel& model) const {
    static_cast<splat::ModelLayout&>(model) = layout_;
    model.data.resize(static_cast<std::size_t>(x.size()));
    B().ToHost(x.view(), {model.data.data(), x.size()});
  }
  const Vector& Result() const { return average_.empty() ? x_ : average_.value(); }
  splat::Model<float> AsModel(const Vector& x, int active_sh_degree) const {
    return {x.data(), layout_, active_sh_degree};
  }

  splat::ModelLayout layout_;
  Adam<B> adam_;
  DensityControl<Space> density_;
  Vector x_, gradient_;
  ParameterMean<B> average_;
  Buffer<splat::PosedCamera, Space> unit_views_;
  double unit_;
};

// All that the stage's further course depends on, beside options and photographs.
template <class B>
struct AdamStageState {
  TrainedModel<B> model;
  ViewOrder order;
  int iteration = 0;     // done
  StageSpan span{0, 0};  // of that one
  double mean_cost = 0;
  bool averages = true;      // false once the mean of the parameters has found no room
  Index before_pruning = 0;  // Gaussians that there were before some were taken out; 0: none yet
  StageCamerasState cameras = {};
  // Seconds that judging Gaussians took, and rounds of it that there was no time for (StagePruning).
  double judged_seconds = 0;
  int scoring_skipped = 0;

  // Whether what was read can be such a state.
  bool IsWhole() const {
    const bool is_within = span.before >= 0 && span.before <= span.after && span.after <= 1;
    return model.IsWhole() && iteration >= 0 && is_within && mean_cost >= 0 && before_pruning >= 0 &&
           judged_seconds >= 0 && scoring_skipped >= 0;
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(model, order, iteration, span.before, span.after, mean_cost, averages, before_pruning, cameras,
            judged_seconds, scoring_skipped);
  }
};

}  // namespace vesta::gs
