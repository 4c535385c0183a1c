// SPDX-License-Identifier: Apache-2.0
// The model during the Adam stage, and the complete state of the stage.
#pragma once

#include <algorithm>
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

// A model in training, with the state of Adam and of density control, in the memory of backend B.
template <class B>
class TrainedModel {
 public:
  using Space = typename B::Space;
  using Vector = typename B::Vector;

  // The learning rate of a Gaussian's position is in its unit of length: half its depth in the nearest of unit_views,
  // in world units (LengthUnit), or `unit` if no such view shows it.
  TrainedModel(const SplatModel& model, Adam<B> adam, DensityControl<Space> density,
               const std::vector<splat::PosedCamera>& unit_views, double unit)
      : layout_(model), adam_(std::move(adam)), density_(std::move(density)), unit_(unit) {
    x_.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
    unit_views_.CopyFrom(HostSpan<const splat::PosedCamera>(unit_views.data(), static_cast<Index>(unit_views.size())));
    ResetStatisticsAndUnits();
  }

  const splat::ModelLayout& layout() const { return layout_; }
  Index count() const { return layout_.count; }
  int sh_degree() const { return layout_.sh_degree; }
  splat::Model<float> kernel_model(int active_sh_degree) const { return AsModel(x_, active_sh_degree); }
  // The averaged parameters if any, else the current ones.
  splat::Model<float> result(int active_sh_degree) const { return AsModel(Result(), active_sh_degree); }
  Adam<B>& adam() { return adam_; }
  DensityControl<Space>& density() { return density_; }
  const Vector& parameters() const { return x_; }

  // Gradient of the first `attributes` attributes. Zero before the first view of an iteration and after Step.
  float* gradient(int attributes) {
    if (gradient_.size() != layout_.Offset(attributes)) gradient_.Resize(layout_.Offset(attributes));
    return gradient_.data();
  }
  void DiscardGradient() { gradient_ = Vector(); }
  void Step(int attributes, double factor) { adam_.Step(layout_, x_, gradient(attributes), attributes, factor); }
  // Adds the current parameters to their average. Densify, SetAttribute and ResetOpacity discard the average. On a
  // device Average may throw OutOfDeviceMemory; the average is then empty.
  void Average() { average_.Add(x_); }

  // Splits and prunes. price: GaussianPrice, for the observed views. Resets the density statistics and length units.
  // Calls rollback_point() first if it adds Gaussians. On a device it may throw OutOfDeviceMemory. If rollback_point()
  // was not called, the model before or after the change can then still be downloaded. Otherwise the caller must return
  // to the rollback point.
  template <class RollbackPoint>
  void Densify(double price, const RollbackPoint& rollback_point) {
    average_.Clear();
    gradient_ = Vector();  // zero between steps
    const DensityPlan<Space> plan = density_.Decide(x_.data(), count(), price);
    if (plan.count > count()) rollback_point();
    if (plan.changes) ApplyPlan(plan);
    ResetStatisticsAndUnits();
  }
  // Gaussian i becomes a copy of the old Gaussian source[i], with its moments if kept[i] is 1, and with moments of zero
  // otherwise. SH degrees must not increase from one copy to the next. Discards the average; resets the density
  // statistics and length units.
  void Replace(const Buffer<std::uint32_t, Space>& source, const Buffer<std::uint8_t, Space>& kept) {
    average_.Clear();
    gradient_ = Vector();
    Rearrange(LayoutOf(source), source, kept);
    ResetStatisticsAndUnits();
  }
  // Keeps only these Gaussians (ascending indices), with their moments, average and density statistics. Resets length
  // units. On a device it may throw OutOfDeviceMemory; the old or the new model can then still be downloaded.
  void Keep(const std::vector<Index>& kept) {
    const std::vector<std::uint32_t> source(kept.begin(), kept.end());
    SelectRows({source, LayoutOfRows(layout_, source)});
    MeasureUnits();
  }
  // Lowers the SH degree of Gaussian i to degrees[i], and removes higher bands with their moments and average. The
  // Gaussians are sorted by degree (OrderByDegree). On a device it may throw OutOfDeviceMemory; the old or the new
  // model can then still be downloaded.
  void SetDegrees(const std::vector<std::uint8_t>& degrees) {
    const DegreeOrder order = OrderByDegree(layout_, degrees);
    if (order.layout != layout_) SelectRows(order);
  }
  // Sets one attribute of all Gaussians that have it. Discards the average.
  void SetAttribute(int attribute, const std::vector<float>& values) {
    average_.Clear();
    const Index rows = layout_.Rows(attribute);
    B().FromHost({values.data(), rows}, x_.view().subspan(layout_.Offset(attribute), rows));
  }
  // Lowers the logarithms of the two longer axes of Gaussian i by by[i]. Keeps the average of earlier parameters.
  void ShrinkLongerAxes(const std::vector<float>& by) {
    const Index n = count();
    const auto rows = x_.view().subspan(layout_.Offset(splat::kLogScale), 3 * n);
    std::vector<float> log_scales(static_cast<std::size_t>(3 * n));
    B().ToHost(rows, {log_scales.data(), 3 * n});
    for (Index i = 0; i < n; ++i) {
      float* axes[3];
      for (int k = 0; k < 3; ++k) axes[k] = &log_scales[static_cast<std::size_t>(k * n + i)];
      std::ranges::sort(axes, {}, [](const float* axis) { return *axis; });
      for (int k = 1; k < 3; ++k) *axes[k] -= by[static_cast<std::size_t>(i)];
    }
    B().FromHost({log_scales.data(), 3 * n}, rows);
  }
  // Limits all opacities to 0.01, clears their moments and discards the average.
  void ResetOpacity() {
    average_.Clear();
    DensityControl<Space>::LowerOpacities(x_.data(), count());
    adam_.Reset(layout_, splat::kOpacity);
  }

  // Copies result() to the host.
  void DownloadResult(SplatModel& model) const { Download(Result(), model); }
  void DownloadParameters(SplatModel& model) const { Download(x_, model); }
  // Frees the gradient and Adam's state, then calls DownloadResult. Ends the stage.
  void Finish(SplatModel& model) {
    gradient_ = Vector();
    adam_.Free();
    DownloadResult(model);
  }
  // Frees the arrays before Visit reads a saved state.
  void Free() {
    x_ = Vector(), gradient_ = Vector();
    average_.Clear();
    adam_.Free();
    density_.ResetStatistics(0);
  }
  // Stops growth, and resets the density statistics.
  void LimitToCurrentCount() {
    density_.LimitGaussians(count());
    ResetStatisticsAndUnits();
  }

  // Whether a state from a file is a consistent model.
  bool IsWhole() const {
    return layout_.IsValid() && x_.size() == layout_.Size() && adam_.IsOf(count(), x_.size()) &&
           average_.IsOf(x_.size()) && density_.IsOf(count());
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(layout_, x_, adam_, average_, density_);
    if constexpr (Archive::kReads) gradient_ = Vector();
  }

 private:
  void ApplyPlan(const DensityPlan<Space>& plan) {
    Rearrange(LayoutOf(plan.source), plan.source, plan.kept);
    density_.InitChildren(plan, x_.data());
  }
  // The layout of a model of the Gaussians source[0], source[1], ... of this model. Their SH degrees must not increase.
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
  // Selects Gaussians with all that is stored for them: the new Gaussian i is the old Gaussian order.source[i].
  void SelectRows(const DegreeOrder& order) {
    gradient_ = Vector();
    const std::vector<std::uint8_t> all(order.source.size(), 1);
    Buffer<std::uint32_t, Space> rows;
    Buffer<std::uint8_t, Space> keeping;
    rows.CopyFrom(HostSpan<const std::uint32_t>(order.source.data(), order.layout.count));
    keeping.CopyFrom(HostSpan<const std::uint8_t>(all.data(), order.layout.count));
    ParameterMean<B> average = average_.OfRows(layout_, order.layout, rows);
    Rearrange(order.layout, rows, keeping);
    average_ = std::move(average);
    density_.Reorder(rows);
    adam_.SetUnits(GatherNumbers(adam_.units(), rows));
  }
  // The new Gaussian i is a copy of the old Gaussian source[i], with the SH bands of `layout`. Its moments are copied
  // if kept[i] is 1; if 0, they become zero.
  void Rearrange(const splat::ModelLayout& layout, const Buffer<std::uint32_t, Space>& source,
                 const Buffer<std::uint8_t, Space>& kept) {
    adam_.Rearrange(layout_, layout, source, kept);
    Vector x;
    x.ResizeForOverwrite(layout.Size());
    GatherGaussians<Space>(layout_, layout, source.data(), nullptr, x_.data(), x.data());
    x_ = std::move(x);
    layout_ = layout;
  }
  // The length units depend on the Gaussians.
  void ResetStatisticsAndUnits() {
    density_.ResetStatistics(count());
    MeasureUnits();
  }
  void MeasureUnits() { adam_.SetUnits(gs::MeasureUnits<Space>(count(), x_.data(), unit_views_, unit_)); }
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

// The complete state of the Adam stage, except options, photographs and the current cameras.
template <class B>
struct AdamStageState {
  TrainedModel<B> model;
  ViewOrder order;
  int iteration = 0;         // iterations done
  StageSpan span{0, 0};      // of the last iteration
  double mean_cost = 0;      // running mean of the cost per pixel and channel
  bool is_averaging = true;  // false if memory for the average was lacking
  Index before_pruning = 0;  // number before the first pruning; 0: not pruned yet
  StageCamerasState cameras = {};
  // Seconds of scoring, and scoring rounds skipped for lack of time (StagePruning).
  double scoring_seconds = 0;
  int scoring_skipped = 0;

  // Counts an iteration of this span. cost: mean of its views, per pixel and channel.
  void CountIteration(const StageSpan& done, double cost) {
    mean_cost = iteration == 0 ? cost : 0.95 * mean_cost + 0.05 * cost;
    ++iteration;
    span = done;
  }

  // Whether a state from a file is valid.
  bool IsWhole() const {
    const bool is_within = span.before >= 0 && span.before <= span.after && span.after <= 1;
    return model.IsWhole() && iteration >= 0 && is_within && mean_cost >= 0 && before_pruning >= 0 &&
           scoring_seconds >= 0 && scoring_skipped >= 0;
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(model, order, iteration, span.before, span.after, mean_cost, is_averaging, before_pruning, cameras,
            scoring_seconds, scoring_skipped);
  }
};

}  // namespace vesta::gs
