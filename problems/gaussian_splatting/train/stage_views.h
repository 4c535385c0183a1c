// The training views of the Adam stage: their photographs at the size that iterations see, the passes over them, and
// their cameras, which may move. What an iteration learns of the model is summed here.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/density/schedule.h"
#include "problems/gaussian_splatting/train/adam_stage_state.h"
#include "problems/gaussian_splatting/train/coarse_views.h"
#include "problems/gaussian_splatting/train/over_ranks.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/share_views.h"
#include "problems/gaussian_splatting/train/stage_cameras.h"
#include "problems/gaussian_splatting/train/stage_targets.h"
#include "problems/gaussian_splatting/train/view_passes.h"

namespace vesta::gs {

template <class B>
class StageViews {
 public:
  explicit StageViews(TrainingSession& session)
      : session_(session), options_(session.options()), near_(NearPlane(session.scene())) {}

  // At full size; to be called before all that follows.
  void LoadFull() {
    if (full_.empty()) full_.Load(session_.training_views(), near_, Own().share());
  }
  // That which an iteration is to see.
  void ChooseSize(const StageSpan& span) {
    const bool wants_coarse = IsCoarse(options_.adam, span);
    if (!wants_coarse) coarse_.Clear();
    if (!wants_coarse || !coarse_.empty() || lacks_coarse_) return;
    std::vector<View> views = CoarseViews(session_.training_views());
    lacks_coarse_ = views.empty();
    coarse_.Hold(std::move(views), near_, Own().share());
  }
  // Whether what was read of the cameras can be a state of theirs.
  bool IsState(const StageCamerasState& cameras) const { return cameras_.IsState(cameras); }
  bool are_coarse() const { return !coarse_.empty(); }
  // Whether there are photographs of half size.
  bool have_coarse() const { return !lacks_coarse_; }
  // The processes that share iterations; null where each does all of them.
  Ranks* sharers() const {
    return options_.adam.views_per_iteration > 1 && !session_.together().is_alone() ? session_.together().ranks()
                                                                                    : nullptr;
  }

  // Where CameraChoice::kAuto is to be decided before an iteration.
  void DecideOnCamerasWhereDue(const StageSpan& span, AdamStageState<B>* state) {
    if (!cameras_.Decides(span, state->cameras)) return;
    SplatModel model;  // bands that are not in use yet are 0
    state->model.DownloadParameters(model);
    full_.Release(), coarse_.Release();
    cameras_.Decide(model, &state->cameras);
  }
  // Forward and backward passes over the next iteration's views. Leaves the sum of their gradients in the model's, and
  // their cameras moved; returns their mean cost, per pixel and channel. Of several processes each has the gradient of
  // those Gaussians that it steps. Then come MoveSharedCameras, the model's step, and TakeStepped.
  double AddGradients(const StageSpan& span, int degree, AdamStageState<B>* state) {
    cameras_.BeginIteration(state->cameras);
    const splat::Model<float> x = state->model.kernel_model(degree);
    const int attributes = splat::NumAttributes(degree), views = options_.adam.views_per_iteration;
    float* const gradient = state->model.gradient(attributes);
    passes().views.Begin({x, attributes}, views, Observes(options_.density, span) ? &state->model.density() : nullptr);
    const OwnViewsOfIterations own = Own();
    for (int k = 0; k < views; ++k) {
      Prefetch(own, *state);
      const std::size_t next = NextView(state->order, *state);
      if (own.Has(next)) AddView(k, next, x, span, gradient, state);
    }
    if (Ranks* const all = sharers()) exchange_.ToOwners(*all, state->model.owners(), &passes().views);
    const ViewCost sum = passes().views.Finish(gradient);
    pixels_ = sum.values / ImageShape::kChannels;
    return sum.objective / sum.values;
  }
  // What views share of their cameras.
  void MoveSharedCameras(const StageSpan& span, AdamStageState<B>* state) {
    if (!cameras_.moves(span, state->cameras)) return;
    if (cameras_.MoveShared(span, &state->cameras)) {
      moved_.resize(full_.size());
      std::iota(moved_.begin(), moved_.end(), std::size_t{0});
    }
    UpdateMovedCameras();
  }
  // Of the latest iteration's views.
  double pixels() const { return pixels_; }
  // After the step: of several processes each has what the others stepped.
  void TakeStepped(AdamStageState<B>* state) {
    if (Ranks* const all = sharers()) exchange_.FromOwners(*all, &passes().views, state->model.shared_parameters());
  }
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

  // Seconds that an iteration on views of full size takes beyond one on coarse ones, by some of the views; none where
  // this process has none. Leaves no trace in what is trained.
  std::optional<double> MeasureFullBeyondCoarse(int degree, TrainedModel<B>* model) {
    const auto seconds = [&](StageTargets<B>& targets, std::size_t view) {
      const double begin = session_.Seconds();
      AddGradient(model->kernel_model(degree), targets[view], model->gradient(splat::NumAttributes(degree)));
      passes().loss.Value();  // waits for a device
      return session_.Seconds() - begin;
    };
    constexpr std::size_t kMostViews = 8;
    const OwnViewsOfIterations own = Own();
    const std::size_t views = std::min(kMostViews, own.size());
    if (views == 0) return std::nullopt;
    seconds(full_, own.At(0, views));  // allocates
    double coarse = 0, full = 0;
    for (std::size_t k = 0; k < views; ++k) {
      coarse += seconds(coarse_, own.At(k, views)) / static_cast<double>(views);
      full += seconds(full_, own.At(k, views)) / static_cast<double>(views);
    }
    model->ForgetGradient();
    return options_.adam.views_per_iteration * std::max(0.0, full - coarse);
  }

 private:
  StageTargets<B>& targets() { return are_coarse() ? coarse_ : full_; }
  ViewPasses<B>& passes() { return passes_ ? *passes_ : passes_.emplace(); }
  OwnViewsOfIterations Own() const {
    return OwnViewsOfIterations(
        OwnViewsInAdam(options_, session_.together().ranks(), static_cast<Index>(session_.training_views().size())));
  }
  // Of those that may be trained on yet.
  std::size_t NextView(ViewOrder& order, const AdamStageState<B>& state) const {
    std::size_t next = order.Next();
    while (cameras_.HoldsBack(next, state.cameras)) next = order.Next();
    return next;
  }
  // Whether any of its own views may be trained on yet.
  bool HasViewsToTrainOn(const OwnViewsOfIterations& own, const AdamStageState<B>& state) const {
    for (Index view = own.share().begin; view < own.share().end; ++view) {
      if (!cameras_.HoldsBack(static_cast<std::size_t>(view), state.cameras)) return true;
    }
    return false;
  }
  // Photographs that are in a store, of the next views.
  void Prefetch(const OwnViewsOfIterations& own, const AdamStageState<B>& state) {
    if (!targets().are_stored() || !HasViewsToTrainOn(own, state)) return;
    ViewOrder order = state.order;
    targets().Prefetch([&] { return own.NextOf([&] { return NextView(order, state); }); });
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
    const density::ScreenPulls pulls =
        density::PullsOf(passes().view, passes().workspace.splat_sums.data(), share * values);
    // The loss is read last, so that on a device all of the view's work is under way.
    passes().views.Add(k, pulls, gradient, [&] { return ViewCost{passes().loss.Value().objective, values}; });
  }

  // The camera of the view that a gradient was just added of.
  void MoveCamera(const StageSpan& span, std::size_t view, const splat::Model<float>& x, AdamStageState<B>* state) {
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
  ViewExchange exchange_;
  double pixels_ = 0;
};

}  // namespace vesta::gs
