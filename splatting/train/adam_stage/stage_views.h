// SPDX-License-Identifier: Apache-2.0
// The views of the Adam stage: their order, and the passes from a model to the gradient of a view's cost.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/profile.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/distributed/sum_of_views.h"
#include "splatting/distributed/term_exchange.h"
#include "splatting/train/adam_stage/stage_cameras.h"
#include "splatting/train/adam_stage/stage_targets.h"
#include "splatting/train/adam_stage/trained_model.h"
#include "splatting/train/session/session.h"
#include "splatting/train/settings/coarse_views.h"
#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {

// The passes over one view, from a model to the gradient of the view's cost: what they work in, and leave there.
template <class B>
struct ViewPasses {
  // |e| itself, as in 3DGS: Adam needs no floor.
  typename SplatBackend<B>::Loss loss{PhotometricWeights{.l1_floor = 0}};
  typename SplatBackend<B>::SplatView view;
  typename SplatBackend<B>::Workspace workspace;
  typename B::Vector image, image_gradient;
  SumOfViews<typename B::Space> views;  // of an iteration

  // Adds the gradient of the cost, which loss.Value() has.
  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, const double* background,
                   float* gradient) {
    const ImageShape shape = target.shape();
    image.ResizeForOverwrite(shape.NumValues());
    image_gradient.ResizeForOverwrite(shape.NumValues());
    view.Build(x, target.camera, background, workspace);
    view.Render(image.data());
    LossGradient(loss, target, image.view(), image_gradient.view());
    view.AddJT(x, image.data(), image_gradient.data(), gradient, workspace);
  }
};

// The training views of the Adam stage: their photographs at the size that iterations see, the passes over them, and
// their cameras, which may move. What an iteration learns of the model is summed here.
template <class B>
class StageViews {
 public:
  explicit StageViews(TrainingSession& session)
      : session_(session), options_(session.options()), near_(NearPlane(session.scene())) {}

  // At full size; to be called before all that follows.
  void LoadFull() {
    if (full_.empty()) full_.Load(session_.training_views(), near_);
  }
  // That which an iteration is to see.
  void ChooseSize(bool wants_coarse) {
    if (!wants_coarse) coarse_.Clear();
    if (!wants_coarse || !coarse_.empty() || lacks_coarse_) return;
    std::vector<View> views = CoarseViews(session_.training_views());
    lacks_coarse_ = views.empty();
    coarse_.Hold(std::move(views), near_);
  }
  // Whether what was read of the cameras can be a state of theirs.
  bool IsState(const StageCamerasState& cameras) const { return cameras_.IsState(cameras); }
  bool are_coarse() const { return !coarse_.empty(); }
  // Whether there are photographs of half size.
  bool have_coarse() const { return !lacks_coarse_; }

  // Where CameraChoice::kAuto is to be decided before an iteration.
  void DecideOnCamerasWhereDue(const StageSpan& span, AdamStageState<B>* state) {
    if (!cameras_.Decides(span, state->cameras)) return;
    const ScopedPhase phase("cameras");
    SplatModel model;  // bands that are not in use yet are 0
    state->model.DownloadParameters(model);
    full_.Release(), coarse_.Release();
    cameras_.Decide(model, &state->cameras);
  }
  // One iteration: the gradients of its views, their cameras, and the step of the model. Returns the mean cost of the
  // views, per pixel and channel. This is the only place where these three are called, so their order stands here.
  double Step(const IterationPlan& plan, int degree, AdamStageState<B>* state) {
    const double cost = AddGradients(plan, degree, state);
    MoveSharedCameras(plan.span, state);
    state->model.Step(splat::NumAttributes(degree), plan.lr_factor);
    return cost;
  }
  // Of the latest iteration's views.
  double pixels() const { return pixels_; }
  // Later iterations see cameras where they are now.
  void UpdateMovedCameras() {
    for (const std::size_t view : moved_) cameras_.UpdateCamera(view, &full_, &coarse_);
    moved_.clear();
  }

  // Before others look at the scene's photographs: they are what was found, and none is held back.
  void LendPhotographs() {
    cameras_.DevelopAll(&full_, &coarse_);
    full_.Release(), coarse_.Release();
  }
  // Those of full size that a device holds.
  std::span<const TargetView<B>> copies() const { return full_.copies(); }
  typename SplatBackend<B>::Workspace& workspace() { return passes().workspace; }
  // What passes work in, until the next one.
  void FreePasses() { passes_.reset(); }

  // Seconds that an iteration on views of full size takes beyond one on coarse ones, by some of the views. Leaves no
  // trace in what is trained.
  double MeasureFullBeyondCoarse(int degree, TrainedModel<B>* model) {
    const ScopedPhase phase("forecast");
    const auto seconds = [&](StageTargets<B>& targets, std::size_t view) {
      const double begin = session_.Seconds();
      AddGradient(model->kernel_model(degree), targets[view], model->gradient(splat::NumAttributes(degree)));
      passes().loss.Value();  // waits for a device
      return session_.Seconds() - begin;
    };
    constexpr std::size_t kMostViews = 8;
    const std::size_t all = full_.size(), views = std::min(kMostViews, all);
    seconds(full_, 0);  // allocates
    double coarse = 0, full = 0;
    for (std::size_t k = 0; k < views; ++k) {
      coarse += seconds(coarse_, k * all / views) / static_cast<double>(views);
      full += seconds(full_, k * all / views) / static_cast<double>(views);
    }
    model->ForgetGradient();
    return options_.adam.batch_size * std::max(0.0, full - coarse);
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;

  // Forward and backward passes over the next iteration's views. Leaves the sum of their gradients in the model's, and
  // their cameras moved; returns their mean cost, per pixel and channel. Several processes divide the views among them,
  // and all get the whole sum.
  double AddGradients(const IterationPlan& plan, int degree, AdamStageState<B>* state) {
    cameras_.BeginIteration(state->cameras);
    const splat::Model<float> x = state->model.kernel_model(degree);
    const int attributes = splat::NumAttributes(degree), views = options_.adam.batch_size;
    float* const gradient = state->model.gradient(attributes);
    passes().views.Begin({x, attributes}, views, plan.observes ? &state->model.density() : nullptr);
    const ProcessGroup& processes = session_.processes();
    const bool are_shared = views > 1 && !processes.is_alone();
    const Share own = are_shared ? processes.OwnShare(views) : Share{0, views};
    for (int k = 0; k < views; ++k) {
      Prefetch(*state);
      const std::size_t next = NextView(state->order, *state);
      if (k >= own.begin && k < own.end) AddView(k, next, x, plan.span, gradient, state);
    }
    if constexpr (kOnHost) {
      if (are_shared) exchange_.AllGather(*processes.ranks(), &passes().views);
    }
    const ViewCost sum = passes().views.Finish(gradient);
    pixels_ = sum.values / ImageShape::kChannels;
    return sum.objective / sum.values;
  }
  // What views share of their cameras.
  void MoveSharedCameras(const StageSpan& span, AdamStageState<B>* state) {
    if (!cameras_.moves(span, state->cameras)) return;
    const ScopedPhase phase("cameras");
    if (cameras_.MoveShared(span, &state->cameras)) {
      moved_.resize(full_.size());
      std::iota(moved_.begin(), moved_.end(), std::size_t{0});
    }
    UpdateMovedCameras();
  }

  StageTargets<B>& targets() { return are_coarse() ? coarse_ : full_; }
  ViewPasses<B>& passes() { return passes_ ? *passes_ : passes_.emplace(); }
  // Of those that may be trained on yet.
  std::size_t NextView(ViewOrder& order, const AdamStageState<B>& state) const {
    std::size_t next = order.Next();
    while (cameras_.HoldsBack(next, state.cameras)) next = order.Next();
    return next;
  }
  // Photographs that are in a store, of the next views.
  void Prefetch(const AdamStageState<B>& state) {
    if (!targets().are_stored()) return;
    ViewOrder order = state.order;
    targets().Prefetch([&] { return NextView(order, state); });
  }

  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, float* gradient) {
    passes().AddGradient(x, target, options_.background.data(), gradient);
  }
  // View k of the iteration.
  void AddView(int k, std::size_t view, const splat::Model<float>& x, const StageSpan& span, float* gradient,
               AdamStageState<B>* state) {
    cameras_.Develop(view, &full_, &coarse_);
    const TargetView<B>& target = targets()[view];
    const ImageShape shape = target.shape();
    const auto values = static_cast<double>(shape.NumValues());
    AddGradient(x, target, gradient);
    if (cameras_.moves(span, state->cameras)) MoveCamera(span, view, x, state);
    const double share = PullShare(shape.width, full_.camera(view).width);
    const density::Grad2dView pulls =
        density::Grad2dOf(passes().view, passes().workspace.splat_sums.data(), share * values);
    // The loss is read last, so that on a device all of the view's work is under way.
    passes().views.Add(k, pulls, gradient, [&] { return ViewCost{passes().loss.Value().objective, values}; });
  }

  // The camera of the view that a gradient was just added of.
  void MoveCamera(const StageSpan& span, std::size_t view, const splat::Model<float>& x, AdamStageState<B>* state) {
    const ScopedPhase phase("cameras");
    const SeenView<B> seen{view,
                           x,
                           targets()[view],
                           passes().view,
                           passes().workspace.splat_sums.data(),
                           passes().image,
                           passes().image_gradient};
    cameras_.Step(span, seen, &state->cameras);
    moved_.push_back(view);
  }

  TrainingSession& session_;
  const TrainOptions& options_;
  double near_;
  StageTargets<B> full_, coarse_;  // coarse_: empty where iterations are on full ones
  bool lacks_coarse_ = false;
  StageCameras cameras_{session_};
  std::vector<std::size_t> moved_;  // by the iteration
  std::optional<ViewPasses<B>> passes_;
  TermExchange exchange_;
  double pixels_ = 0;
};

}  // namespace vesta::gs
