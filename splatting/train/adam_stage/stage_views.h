// SPDX-License-Identifier: Apache-2.0
// Views of the Adam stage: their order, and the passes that give the gradient of a view's cost.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/profile.h"
#include "kernels/core/random.h"
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

// Workspace and results of the passes over one view.
template <class B>
struct ViewPasses {
  // As in 3DGS, |e| is not smoothed near 0; only LM needs smoothing.
  typename SplatBackend<B>::Loss loss{PhotometricWeights{.l1_floor = 0}};
  typename SplatBackend<B>::SplatView view;
  typename SplatBackend<B>::Workspace workspace;
  typename B::Vector image, image_gradient;
  typename B::Vector composed;          // the photograph over the background of the pass, if it has transparency
  SumOfViews<typename B::Space> views;  // sums the gradients of an iteration's views

  // With one background for the photograph and the rendered view.
  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, const double* background,
                   float* gradient) {
    AddGradient(x, target, background, background, gradient);
  }
  // Renders the view over a background and adds the gradient of its cost to `gradient`. loss.Value() then returns the
  // cost. own_background: the background of the photographs.
  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, const double* own_background,
                   const double* background, float* gradient) {
    const ImageShape shape = target.shape();
    image.ResizeForOverwrite(shape.NumValues());
    image_gradient.ResizeForOverwrite(shape.NumValues());
    view.Build(x, target.camera, background, workspace);
    view.Render(image.data());
    typename B::ConstVectorView truth(target.truth);
    if (background != own_background) {
      composed.ResizeForOverwrite(shape.NumValues());
      ComposeOver(target, own_background, background, composed.view());
      truth = composed.view();
    }
    LossGradient(loss, target, truth, image.view(), image_gradient.view());
    view.AddJT(x, image.data(), image_gradient.data(), gradient, workspace);
  }
};

// The training views of the Adam stage: photographs at the current size, passes over them, and cameras. Sums the
// gradients and density statistics of an iteration.
template <class B>
class StageViews {
 public:
  explicit StageViews(TrainingSession& session)
      : session_(session), options_(session.options()), near_(NearPlane(session.scene())) {}

  // Call first.
  void LoadFull() {
    if (full_.empty()) full_.Load(session_.training_views(), near_);
  }
  void ChooseSize(bool wants_coarse) {
    if (!wants_coarse) coarse_.Clear();
    if (!wants_coarse || !coarse_.empty() || lacks_coarse_) return;
    std::vector<View> views = CoarseViews(session_.training_views());
    lacks_coarse_ = views.empty();
    coarse_.LoadOwned(std::move(views), near_);
  }
  // Whether a camera state from a file is valid.
  bool IsState(const StageCamerasState& cameras) const { return cameras_.IsState(cameras); }
  bool are_coarse() const { return !coarse_.empty(); }
  // Whether half-size photographs exist.
  bool have_coarse() const { return !lacks_coarse_; }

  // Decides whether cameras are refined (CameraChoice::kAuto), if due before this iteration.
  void DecideOnCamerasWhereDue(const StageSpan& span, AdamStageState<B>* state) {
    if (!cameras_.IsDecisionDue(span, state->cameras)) return;
    const ScopedPhase phase("cameras");
    SplatModel model;  // SH bands not in use yet are 0
    state->model.DownloadParameters(model);
    full_.Release(), coarse_.Release();
    cameras_.Decide(model, &state->cameras);
  }
  // One iteration: gradients of the views, camera steps, then the step of the Gaussians. Returns the mean cost of the
  // views, per pixel and channel.
  double Step(const IterationPlan& plan, int degree, AdamStageState<B>* state) {
    const double cost = AddGradients(plan, degree, state);
    MoveSharedCameras(plan.span, state);
    state->model.Step(splat::NumAttributes(degree), plan.lr_factor);
    return cost;
  }
  // Pixels of the latest iteration.
  double pixels() const { return pixels_; }
  // Copies the moved cameras to the targets, for later iterations.
  void UpdateMovedCameras() {
    for (const std::size_t view : moved_) cameras_.UpdateCamera(view, &full_, &coarse_);
    moved_.clear();
  }

  // Call before other code reads the scene's photographs. Applies the inverse of the found exposures to them, and frees
  // the current photograph of a store.
  void ReleasePhotographs() {
    cameras_.DevelopAll(&full_, &coarse_);
    full_.Release(), coarse_.Release();
  }
  // The full-size copies on a device.
  std::span<const TargetView<B>> copies() const { return full_.copies(); }
  typename SplatBackend<B>::Workspace& workspace() { return passes().workspace; }
  // The next pass allocates the workspace again.
  void FreePasses() { passes_.reset(); }

  // Measures, on up to eight views, the time of a full-size iteration minus the time of a half-size one, in seconds.
  // Does not change the training.
  double MeasureFullMinusCoarse(int degree, TrainedModel<B>* model) {
    const ScopedPhase phase("forecast");
    const auto seconds = [&](StageTargets<B>& targets, std::size_t view) {
      const double begin = session_.Seconds();
      AddGradient(model->kernel_model(degree), targets[view], model->gradient(splat::NumAttributes(degree)));
      passes().loss.Value();  // waits for the device
      return session_.Seconds() - begin;
    };
    constexpr std::size_t kMostViews = 8;
    const std::size_t all = full_.size(), views = std::min(kMostViews, all);
    seconds(full_, 0);  // warm-up, allocates
    double coarse = 0, full = 0;
    for (std::size_t k = 0; k < views; ++k) {
      coarse += seconds(coarse_, k * all / views) / static_cast<double>(views);
      full += seconds(full_, k * all / views) / static_cast<double>(views);
    }
    model->DiscardGradient();
    return options_.adam.batch_size * std::max(0.0, full - coarse);
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;
  static constexpr std::uint64_t kBackgrounds = 0x6261636b;  // the stream of random numbers

  // The passes over the views of the next iteration. Stores the summed gradient in the model, moves the cameras and
  // returns the mean cost per pixel and channel. Ranks divide the views; each gets the whole sum.
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
  // The next view that is not held out.
  std::size_t NextView(ViewOrder& order, const AdamStageState<B>& state) const {
    std::size_t next = order.Next();
    while (cameras_.IsHeldOut(next, state.cameras)) next = order.Next();
    return next;
  }
  void Prefetch(const AdamStageState<B>& state) {
    if (!targets().are_stored()) return;
    ViewOrder order = state.order;
    targets().Prefetch([&] { return NextView(order, state); });
  }

  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, float* gradient) {
    passes().AddGradient(x, target, options_.background.data(), gradient);
  }
  // Opaque Gaussians of a fixed background's colour would grow around a cut-out object.
  void AddGradientOverRandom(std::size_t drawn, const splat::Model<float>& x, const TargetView<B>& target,
                             float* gradient) {
    CounterRandom random(options_.seed, kBackgrounds, drawn);
    double background[3];
    for (double& channel : background) channel = random.Uniform();
    passes().AddGradient(x, target, options_.background.data(), background, gradient);
  }
  void AddView(int k, std::size_t view, const splat::Model<float>& x, const StageSpan& span, float* gradient,
               AdamStageState<B>* state) {
    cameras_.Develop(view, &full_, &coarse_);
    const TargetView<B>& target = targets()[view];
    const ImageShape shape = target.shape();
    const auto values = static_cast<double>(shape.NumValues());
    if (options_.random_background && target.transparency.size() > 0) {
      AddGradientOverRandom(state->order.drawn(), x, target, gradient);
    } else {
      AddGradient(x, target, gradient);
    }
    if (cameras_.moves(span, state->cameras)) MoveCamera(span, view, x, state);
    const density::PullView pull_view{
        .rank_of = passes().view.rank_of().data(),
        .splats = passes().view.splats().data(),
        .cotangents = passes().workspace.splat_sums.data(),
        .scale = static_cast<float>(full_.camera(view).width) / static_cast<float>(shape.width)};
    // Read the loss last, so that a device already runs all work of the view.
    passes().views.Add(k, pull_view, gradient, [&] { return ViewCost{passes().loss.Value().objective, values}; });
  }

  // Moves the camera of the view that was just processed.
  void MoveCamera(const StageSpan& span, std::size_t view, const splat::Model<float>& x, AdamStageState<B>* state) {
    const ScopedPhase phase("cameras");
    const ProcessedView<B> seen{view,
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
  StageTargets<B> full_, coarse_;  // coarse_: empty with full-size views
  bool lacks_coarse_ = false;
  StageCameras cameras_{session_};
  std::vector<std::size_t> moved_;  // views whose cameras moved since UpdateMovedCameras
  std::optional<ViewPasses<B>> passes_;
  TermExchange exchange_;
  double pixels_ = 0;
};

}  // namespace vesta::gs
