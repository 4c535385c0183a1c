// Stage one: Adam on one view an iteration, or a few, with adaptive density. For every memory space: parameters,
// gradient and moments stay in it throughout.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/density/schedule.h"
#include "problems/gaussian_splatting/memory/memory_plan.h"
#include "problems/gaussian_splatting/train/adam_stage_state.h"
#include "problems/gaussian_splatting/train/coarse_views.h"
#include "problems/gaussian_splatting/train/evaluate_or_download.h"
#include "problems/gaussian_splatting/train/forecast.h"
#include "problems/gaussian_splatting/train/kept_state.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/share_views.h"
#include "problems/gaussian_splatting/train/stage_pace.h"
#include "problems/gaussian_splatting/train/stage_parsimony.h"
#include "problems/gaussian_splatting/train/stage_targets.h"
#include "problems/gaussian_splatting/train/view_passes.h"

namespace vesta::gs {

template <class B>
class AdamStage {
 public:
  // model: to start from, and where the result goes.
  AdamStage(TrainingSession& session, SplatModel& model)
      : session_(session),
        options_(session.options()),
        result_(model),
        near_(NearPlane(session.scene())),
        begin_seconds_(session.Seconds()),
        saved_(session.TakeSavedStage(Stage::kAdam)) {}

  // All that is left to do. On a device throws OutOfDeviceMemory; then what follows may be called.
  void Run() {
    if (!state_) Begin();
    if (targets_.empty()) targets_.Show(session_.training_views(), near_, OwnViews().share());
    while (!finished_ && !state_->span.is_last() && !session_.stopped()) Iterate();
    if (!finished_) Finish();
  }

  int iteration() const { return state_ ? state_->iteration : 0; }
  // Of a stage that could not begin: what it was to begin from is the session's again.
  void GiveBackSavedStage() { session_.GiveBackSavedStage(std::exchange(saved_, std::nullopt)); }
  Index gaussians() const { return state_->model.count(); }
  // Back to before the Gaussians last became more, to go on without. False where there is no such state.
  bool GoBackBeforeGrowth() {
    if (before_growth_.empty()) return false;
    passes_.emplace();
    state_->model.Free();
    // Cameras stay where they were found since, and with them what was learned of them.
    StageCamerasState cameras = std::move(state_->cameras);
    if constexpr (!kOnHost) before_growth_.MoveTo(*state_);
    state_->cameras = std::move(cameras);
    state_->model.StayAsMany();
    // What that iteration did besides.
    if (ResetsOpacity(options_.density, state_->span)) state_->model.ResetOpacity();
    return true;
  }
  // Leaves the model after the last iteration, recorded.
  void Finish() {
    ShowMoved();
    if (recorded_ != state_->iteration) Record();
    parsimony_.NoteWhoStayed(*state_);
    passes_.reset();
    state_->model.Finish(result_);
    finished_ = true;
  }

 private:
  using KeptState = gs::KeptState<typename B::Space>;
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;

  static AdamStageState<B> StartState(const TrainingSession& session, const SplatModel& model) {
    const TrainOptions& options = session.options();
    // Rates stay those of the cameras as they were given.
    const std::vector<const View*>& views = session.cameras().given();
    const Scene& scene = session.scene();
    return {TrainedModel<B>(model, Adam<B>(options.rates, options.adam.metric, options.adam.views_per_iteration),
                            DensityControl<typename B::Space>(options.density, scene.extent, options.seed),
                            UnitViews(views, NearPlane(scene)), scene.extent),
            ViewOrder(views.size(), options.seed, static_cast<std::size_t>(options.adam.views_per_iteration))};
  }
  void Begin() {
    state_.emplace(StartState(session_, result_));
    if constexpr (kOnHost) result_.data = std::vector<float>();  // until the stage is done state_ has it
    if (saved_) Restore(*saved_);
    saved_.reset();
    state_->model.DivideAmong(Sharers());
  }
  void Restore(const std::string& bytes) {
    try {
      ArchiveReader reader(bytes);
      reader(*state_);
    } catch (const OutOfDeviceMemory&) {
      state_.reset();  // it has not begun
      throw;
    } catch (const Error&) {
      session_.RefuseSavedStage();
    }
    if (!state_->IsWhole()) session_.RefuseSavedStage();
  }

  int ActiveDegree(const StageSpan& span) const {
    return ActiveShDegree(options_.adam, state_->model.sh_degree(), span);
  }

  // The iteration to come.
  StageSpan NextSpan() const {
    const int n = NumIterations(options_.adam), done = state_->iteration;
    const double before = state_->span.after, planned = 1.0 * done / n;
    if (options_.time_limit <= 0) return {planned, (done + 1.0) / n};
    const double left = n - done, in_time = session_.OfFirst(IterationsInTime());
    // A limit that never binds changes no bit.
    if (before == planned && left <= in_time) return {planned, (done + 1.0) / n};
    return {before, before + (1 - before) / std::max(1.0, std::min(left, in_time))};
  }
  // How many more the time limit allows.
  double IterationsInTime() const {
    constexpr double kAny = 1e300;
    const double seconds = session_.SecondsForAdam(SecondsPerPixel());
    if (!pace_.is_known() || seconds >= kAny) return kAny;
    return Ahead().IterationsIn(seconds);
  }
  // Needs pace_.is_known().
  StageAhead Ahead() const {
    return ForecastStage(pace_, growth_, options_, state_->span.after, state_->model.count(), !lacks_halves_,
                         state_->before_pruning, parsimony_.JudgingIterations());
  }

  void Record() {
    const int degree = ActiveDegree(state_->span);
    const splat::Model<float> result = state_->model.result(degree);
    const auto on_host = [&] { return OnHost(result); };
    cameras_.DevelopAll(&targets_, &coarse_targets_);
    targets_.Release(), coarse_targets_.Release();
    const auto evaluate = [&] {
      return EvaluateOrDownload(
          session_, targets_.copies(), [&] { return result; }, passes_->workspace, on_host);
    };
    session_.Record(Stage::kAdam, state_->iteration, ModelToRecord{state_->model.count(), evaluate, on_host});
    recorded_ = state_->iteration;
  }
  // Where it is not there already it is downloaded, for as long as nothing else is.
  splat::Model<float> OnHost(const splat::Model<float>& result) {
    if constexpr (!kOnHost) {
      state_->model.DownloadResult(result_);
      return {result_.data.data(), result, result.active_sh_degree};
    } else {
      return result;
    }
  }

  // What the iteration trains on.
  StageTargets<B>& TargetsOf(const StageSpan& span) {
    const bool is_coarse = IsCoarse(options_.adam, span);
    if (!is_coarse) coarse_targets_.Clear();
    if (is_coarse && coarse_targets_.empty() && !lacks_halves_) {
      std::vector<View> views = CoarseViews(session_.training_views());
      lacks_halves_ = views.empty();
      coarse_targets_.Hold(std::move(views), near_, OwnViews().share());
    }
    return coarse_targets_.empty() ? targets_ : coarse_targets_;
  }

  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, float* gradient) {
    passes_->AddGradient(x, target, options_.background.data(), gradient);
  }
  void DecideOnCameras() {
    SplatModel model;  // bands that are not in use yet are 0
    state_->model.DownloadParameters(model);
    cameras_.Decide(model, &state_->cameras);
  }
  // The camera of the view that a gradient was just added of.
  void MoveCamera(const StageSpan& span, std::size_t view, const splat::Model<float>& x, StageTargets<B>& targets) {
    const SeenView<B> seen{view,
                           x,
                           targets[view],
                           passes_->view,
                           passes_->workspace.splat_sums.data(),
                           passes_->image,
                           passes_->image_gradient};
    cameras_.Step(span, seen, &state_->cameras);
    moved_.push_back(view);
  }
  // Iterations to come see cameras where they are now.
  void ShowMovedCameras(const StageSpan& span) {
    if (cameras_.MoveShared(span, &state_->cameras)) {
      moved_.resize(targets_.size());
      std::iota(moved_.begin(), moved_.end(), std::size_t{0});
    }
    ShowMoved();
  }
  void ShowMoved() {
    for (const std::size_t view : moved_) cameras_.Show(view, &targets_, &coarse_targets_);
    moved_.clear();
  }
  // The processes that share iterations; null where each does all of them.
  Ranks* Sharers() const {
    return options_.adam.views_per_iteration > 1 && !session_.trains_alone() ? session_.ranks() : nullptr;
  }
  OwnViewsOfIterations OwnViews() const {
    return {session_.ranks(), options_.adam.views_per_iteration, session_.training_views().size()};
  }
  // Of those that may be trained on yet.
  std::size_t NextView(ViewOrder& order) const {
    std::size_t next = order.Next();
    while (cameras_.HoldsBack(next, state_->cameras)) next = order.Next();
    return next;
  }
  // The mean cost of the iteration's views a value; their gradients are added up.
  double AddGradients(const splat::Model<float>& x, StageTargets<B>& targets, float* gradient, const StageSpan& span) {
    const int views = options_.adam.views_per_iteration;
    passes_->views.Begin({x, splat::NumAttributes(x.active_sh_degree)}, views,
                         Observes(options_.density, span) ? &state_->model.density() : nullptr);
    const OwnViewsOfIterations own = OwnViews();
    for (int k = 0; k < views; ++k) {
      if (!own.empty()) {
        targets.Expect([&] {
          return [&, order = state_->order]() mutable { return own.NextOf([&] { return NextView(order); }); };
        });
      }
      const std::size_t next = NextView(state_->order);
      if (!own.Has(next)) continue;
      cameras_.Develop(next, &targets_, &coarse_targets_);
      const TargetView<B>& target = targets[next];
      const ImageShape shape = target.shape();
      const auto values = static_cast<double>(shape.NumValues());
      AddGradient(x, target, gradient);
      if (cameras_.moves(span, state_->cameras)) MoveCamera(span, next, x, targets);
      const double share = PullShare(shape.width, targets_.camera(next).width);
      const density::ScreenPulls pulls =
          density::PullsOf(passes_->view, passes_->workspace.splat_sums.data(), share * values);
      // The loss is read last, so that on a device all of the view's work is under way.
      passes_->views.Add(k, pulls, gradient, [&] { return ViewCost{passes_->loss.Value().objective, values}; });
    }
    if (Ranks* const sharers = Sharers()) exchange_.ToOwners(*sharers, state_->model.owners(), &passes_->views);
    const ViewCost sum = passes_->views.Finish(gradient);
    pixels_ = sum.values / ImageShape::kChannels;
    return sum.objective / sum.values;
  }
  // By the latest iteration; the first takes longer than any other and does not count.
  void MeasurePace(double seconds) {
    pace_.Observe(!coarse_targets_.empty(), state_->model.count(), seconds);
    if (!std::exchange(is_warm_, true)) return;
    worked_seconds_ += seconds, worked_pixels_ += pixels_;
  }
  // Of training; 0: not known.
  double SecondsPerPixel() const { return worked_pixels_ > 0 ? worked_seconds_ / worked_pixels_ : 0; }

  // Tells what the whole stage will take: a second after its start, and when it is seen how the Gaussians grow.
  void PredictWhereDue(int degree) {
    const bool grows = Observes(options_.density, state_->span);
    const bool is_first_guess = grows && !growth_.is_known();
    const bool is_late = session_.Seconds() - begin_seconds_ >= 1;
    if (!pace_.is_known() || has_predicted_ || (is_first_guess && (!is_late || has_guessed_))) return;
    (is_first_guess ? has_guessed_ : has_predicted_) = true;
    if (!is_first_guess && !coarse_targets_.empty()) MeasureFullSize(degree);
    const StageAhead ahead = Ahead();
    const double rows = std::ceil((1 - state_->span.after) * options_.adam.evaluations);
    const double row = session_.EvaluationAhead(SecondsPerPixel()) * ahead.full_seconds /
                       pace_.Seconds(false, static_cast<double>(state_->model.count()));
    const double left =
        (NumIterations(options_.adam) - state_->iteration) * ahead.seconds + ahead.change_seconds + rows * row;
    const double total = session_.TotalSeconds();
    const double seconds = options_.time_limit > 0 ? std::min(options_.time_limit, total + left) : total + left;
    session_.Predict({is_first_guess, total, seconds, PredictMib(degree, ahead.most_gaussians), ahead.gaussians});
  }
  double PredictMib(int degree, double gaussians) {
    const MemoryScene now =
        CountMemory(OnHost(state_->model.kernel_model(degree)), session_.planned_views(), near_, 8, false);
    const MemoryScene then = now.Scaled(static_cast<Index>(gaussians));
    if constexpr (kOnHost) {
      return PredictedMib(then, options_, 0);
    } else {
      return PredictedDeviceMib(then, options_, 0, session_.kept_on_device());
    }
  }
  // How much longer iterations on views of full size take, by some of the views. Leaves no trace in what is trained.
  void MeasureFullSize(int degree) {
    const int attributes = splat::NumAttributes(degree);
    const auto seconds = [&](StageTargets<B>& targets, std::size_t view) {
      const double begin = session_.Seconds();
      AddGradient(state_->model.kernel_model(degree), targets[view], state_->model.gradient(attributes));
      passes_->loss.Value();  // waits for a device
      return session_.Seconds() - begin;
    };
    constexpr std::size_t kMostViews = 8;
    const OwnViewsOfIterations own = OwnViews();
    const std::size_t views = std::min(kMostViews, own.size());
    if (views == 0) return;
    seconds(targets_, own.At(0, views));  // allocates
    double coarse = 0, full = 0;
    for (std::size_t k = 0; k < views; ++k) {
      coarse += seconds(coarse_targets_, own.At(k, views)) / static_cast<double>(views);
      full += seconds(targets_, own.At(k, views)) / static_cast<double>(views);
    }
    state_->model.ForgetGradient();
    pace_.SetFullBeyondCoarse(options_.adam.views_per_iteration * std::max(0.0, full - coarse));
  }

  void Iterate() {
    const int it = state_->iteration + 1;
    const StageSpan span = NextSpan();
    const int degree = ActiveDegree(span), attributes = splat::NumAttributes(degree);
    const bool observes = Observes(options_.density, span);
    // The gradient is that of a sum over pixels and views; Adam's steps do not depend on its scale.
    StageTargets<B>& targets = TargetsOf(span);
    const double begin = session_.Seconds();
    if (cameras_.Decides(span, state_->cameras)) DecideOnCameras();
    const double cost =
        AddGradients(state_->model.kernel_model(degree), targets, state_->model.gradient(attributes), span);
    if (cameras_.moves(span, state_->cameras)) ShowMovedCameras(span);
    state_->model.Step(attributes, RateFactor(options_.adam, span));
    if (Ranks* const sharers = Sharers()) {
      exchange_.FromOwners(*sharers, &passes_->views, state_->model.shared_parameters());
    }
    state_->iteration = it, state_->span = span;
    state_->mean_cost = it == 1 ? cost : 0.95 * state_->mean_cost + 0.05 * cost;
    ForgetGrowthThatHolds();
    if (state_->averages && Averages(options_.adam, span, it)) Average();
    MeasurePace(session_.Seconds() - begin);
    const double ahead = session_.EvaluationAhead(SecondsPerPixel());
    const bool is_due = span.Reaches(1.0 / options_.adam.evaluations);
    const bool is_stopped = session_.ShouldStop(ahead);
    if (span.is_last() || is_stopped || (is_due && session_.HasTimeToRecord(ahead))) Record();
    const bool is_end = span.is_last() || session_.has_reached_target(), is_last = is_end || is_stopped;
    session_.SnapshotWhereDue(Stage::kAdam, it, [&] { return OnHost(state_->model.result(degree)); });
    if (is_last && !is_end) {
      state_->model.DownloadResult(result_);
      parsimony_.NoteWhoStayed(*state_);
      finished_ = true;
    }
    // After the row of the history: what has just been cloned or split is worse for some iterations. Where the stage is
    // stopped it is done for the sake of the state that is saved, and at the end not at all.
    if (observes && !is_end && (!is_last || session_.any_saves())) ChangeGaussians(it);
    if (!is_end && (!is_last || session_.any_saves())) {
      parsimony_.TakeOut(*state_, degree, [&] {
        cameras_.DevelopAll(&targets_, &coarse_targets_);
        passes_.emplace(), targets_.Release(), coarse_targets_.Release();
        before_growth_ = KeptState();  // of more than there are now
      });
    }
    session_.Report({Stage::kAdam, it, ExpectedIterations(), session_.Seconds(), state_->mean_cost,
                     session_.latest_psnr(), state_->model.count(), ""});
    if (!is_last) PredictWhereDue(degree);
    const WriteState write = [&](ArchiveWriter& archive) { archive(*state_); };
    const auto gather = [&](const std::vector<bool>& savers) { state_->model.GatherFor(savers); };
    if (!is_end) session_.SaveWhereDue(Stage::kAdam, it, write, Sharers() ? BeforeSaving(gather) : BeforeSaving());
    const auto on_host = [&] { return OnHost(state_->model.result(degree)); };
    if (!is_last) session_.AttendToWatch(Stage::kAdam, it, on_host, Sharers() ? WriteState() : write);
    if (is_end) Finish();
  }

  // In all, as far as is known.
  int ExpectedIterations() const {
    const double left = state_->span.is_last()
                            ? 0
                            : std::min<double>(NumIterations(options_.adam) - state_->iteration, IterationsInTime());
    return state_->iteration + static_cast<int>(std::ceil(left));
  }

  void ChangeGaussians(int it) {
    if (Densifies(options_.density, state_->span)) {
      const Index before = state_->model.count();
      const double begin = session_.Seconds();
      passes_.emplace();  // the new bases need room while the old ones are there
      state_->model.Densify(it, [&] {
        if constexpr (!kOnHost) KeepStateBeforeGrowth();
      });
      growth_.Observe(before, state_->model.count());
      pace_.ObserveChange(state_->model.count(), session_.Seconds() - begin);
    }
    if (ResetsOpacity(options_.density, state_->span)) state_->model.ResetOpacity();
  }

  // The mean is an improvement; for want of its room training does not end.
  void Average() {
    try {
      state_->model.Average();
    } catch (const OutOfDeviceMemory& error) {
      if (!session_.trains_alone()) throw;
      state_->averages = false;
      session_.Note(fmt::format("Adam leaves its last parameters, not their mean: {}", error.what()));
    }
  }

  // On the GPU as long as that takes no room from what was planned for there.
  void KeepStateBeforeGrowth() {
    if (!session_.trains_alone()) return;  // several do not go back
    before_growth_ = KeptState();
    growth_at_ = state_->iteration;
    const double bytes = KeptState::ArrayBytes(*state_);
    if (bytes <= session_.spare_device_bytes()) {
      try {
        before_growth_ = KeptState(*state_, true);
        session_.NoteKeptOnDevice(bytes);
        return;
      } catch (const OutOfDeviceMemory&) {  // less is free than was
      }
    }
    before_growth_ = KeptState(*state_, false);
  }
  // Once every view has been through with the Gaussians there are, there is room for them.
  void ForgetGrowthThatHolds() {
    const auto seen = static_cast<std::size_t>(state_->iteration - growth_at_) *
                      static_cast<std::size_t>(options_.adam.views_per_iteration);
    if (!before_growth_.empty() && seen >= 2 * session_.training_views().size()) before_growth_ = KeptState();
  }

  TrainingSession& session_;
  const TrainOptions& options_;
  SplatModel& result_;
  double near_;
  double begin_seconds_;
  std::optional<std::string> saved_;  // to begin from
  std::optional<AdamStageState<B>> state_;
  StageTargets<B> targets_, coarse_targets_;
  StageCameras cameras_{session_};
  std::vector<std::size_t> moved_;  // by the iteration
  ViewExchange exchange_;
  bool lacks_halves_ = false, finished_ = false;
  std::optional<ViewPasses<B>> passes_{std::in_place};
  KeptState before_growth_;  // of AdamStageState
  int growth_at_ = 0, recorded_ = 0;
  StagePace pace_;
  StageParsimony<B> parsimony_{session_, pace_};
  GrowthForecast growth_;
  bool has_guessed_ = false, has_predicted_ = false;
  double pixels_ = 0;  // of the latest iteration's views
  double worked_seconds_ = 0, worked_pixels_ = 0;
  bool is_warm_ = false;
};

}  // namespace vesta::gs
