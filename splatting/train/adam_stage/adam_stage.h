// SPDX-License-Identifier: Apache-2.0
// The Adam stage: its iterations, and what happens where the memory of a device does not suffice.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "kernels/core/profile.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/adam_stage/rollback_point.h"
#include "splatting/train/adam_stage/stage_pruning.h"
#include "splatting/train/adam_stage/stage_views.h"
#include "splatting/train/adam_stage/trained_model.h"
#include "splatting/train/forecast/forecast.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// Stage one: Adam on one view an iteration, or a few, with adaptive density. For every memory space: parameters,
// gradient and moments stay in it throughout.
template <class B>
class AdamStage {
 public:
  // model: to start from, and where the result goes.
  AdamStage(TrainingSession& session, SplatModel& model)
      : session_(session), options_(session.options()), result_(model), saved_(session.saved().Take(Stage::kAdam)) {}

  // All that is left to do. On a device throws OutOfDeviceMemory; then what follows may be called.
  void Run() {
    if (!state_) Begin();
    views_.LoadFull();
    while (!finished_ && !state_->span.is_last() && !session_.early_end().stopped()) Iterate();
    if (!finished_) Finish();
  }

  int iteration() const { return state_ ? state_->iteration : 0; }
  // Of a stage that could not begin: what it was to begin from is the session's again.
  void GiveBackSavedStage() { session_.saved().GiveBack(std::exchange(saved_, std::nullopt)); }
  Index gaussians() const { return state_->model.count(); }
  // Back to before the Gaussians last became more, to go on without. False where there is no such state.
  bool RollBack() {
    if (rollback_point_.empty()) return false;
    views_.FreePasses();
    if constexpr (!kOnHost) rollback_point_.GoBack(&*state_);
    // What that iteration did besides.
    if (session_.schedule().At(state_->span).resets_opacity) state_->model.ResetOpacity();
    return true;
  }
  // Leaves the model after the last iteration, recorded.
  void Finish() {
    views_.UpdateMovedCameras();
    if (recorded_ != state_->iteration) Record();
    pruning_.NoteWhoStayed(*state_, state_->model.count());
    views_.FreePasses();
    state_->model.Finish(result_);
    finished_ = true;
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;

  static AdamStageState<B> StartState(const TrainingSession& session, const SplatModel& model) {
    const TrainOptions& options = session.options();
    // Rates stay those of the cameras as they were given.
    const std::vector<const View*>& views = session.cameras().given();
    const Scene& scene = session.scene();
    DensityOptions density = options.density;
    density.max_gaussians = session.plan().max_gaussians;
    return {TrainedModel<B>(model, Adam<B>(options.lr, options.adam.second_moment, options.adam.batch_size),
                            DensityControl<typename B::Space>(density, scene.extent, options.seed),
                            UnitViews(views, NearPlane(scene)), scene.extent),
            ViewOrder(views.size(), options.seed, static_cast<std::size_t>(options.adam.batch_size))};
  }
  void Begin() {
    state_.emplace(StartState(session_, result_));
    if constexpr (kOnHost) result_.data = std::vector<float>();  // until the stage is done state_ has it
    if (saved_) Restore(*saved_);
    saved_.reset();
  }
  void Restore(std::string_view bytes) {
    try {
      ArchiveReader reader(bytes);
      session_.saved().Validate([&] { reader(*state_); });
    } catch (const OutOfDeviceMemory&) {
      state_.reset();  // it has not begun
      throw;
    }
    if (!state_->IsWhole() || !views_.IsState(state_->cameras)) session_.saved().Refuse();
    const int n = session_.schedule().iterations(), views = options_.adam.batch_size;
    if (state_->iteration >= n) {
      Fail(kBadArgument,
           "{}: {} iterations of Adam are done and {} asked for; ask for more by --iterations, or give a --time_limit",
           session_.saved().path(), state_->iteration * views, n * views);
    }
  }

  StageProgress Progress() const {
    return {.iteration = state_->iteration,
            .span = state_->span,
            .gaussians = state_->model.count(),
            .max_gaussians = session_.plan().max_gaussians,
            .before_pruning = state_->before_pruning,
            .has_coarse_views = views_.have_coarse()};
  }

  void Iterate() {
    const IterationPlan plan = session_.schedule().At(outlook_.NextSpan(Progress()));
    const int degree = DegreeOf(plan);
    Step(plan, degree);
    // Before Gaussians change: right after they were cloned or split the splat is worse.
    const bool is_stopped = RecordWhereDue(plan);
    const auto on_host = [&] { return OnHost(state_->model.result(degree)); };
    session_.interim().SnapshotWhereDue(Stage::kAdam, state_->iteration, on_host);
    if (plan.span.is_last() || session_.early_end().has_reached_target()) {
      Report();
      return Finish();
    }
    if (is_stopped) return Stop(plan, degree);
    ChangeGaussians(plan, degree);
    Report();
    PredictWhereDue(plan, degree);
    Save();
    session_.interim().AttendToWatch(Stage::kAdam, state_->iteration, on_host, Writer());
  }
  // Leaves the model after this iteration, which was recorded. What is saved, to go on from, is of after its change of
  // the Gaussians; what is said of the end is not in it, as the stage will have another.
  void Stop(const IterationPlan& plan, int degree) {
    state_->model.DownloadResult(result_);
    finished_ = true;
    const Index gaussians = state_->model.count();
    if (session_.processes().OnAny(session_.interim().Saves())) ChangeGaussians(plan, degree);
    Report();
    Save();
    pruning_.NoteWhoStayed(*state_, gaussians);
  }
  void Report() {
    session_.Report({Stage::kAdam, state_->iteration, outlook_.ExpectedIterations(Progress()), session_.Seconds(),
                     state_->mean_cost, session_.history().training_psnr(), state_->model.count(), ""});
  }
  void Save() { session_.interim().SaveWhereDue(Stage::kAdam, state_->iteration, Writer()); }
  WriteState Writer() {
    return [&](ArchiveWriter& archive) { archive(*state_); };
  }

  // Of the harmonics that are in use.
  int DegreeOf(const IterationPlan& plan) const { return std::min(plan.most_sh_degree, state_->model.sh_degree()); }

  // The gradient is that of a sum over pixels and views; Adam's steps do not depend on its scale.
  void Step(const IterationPlan& plan, int degree) {
    views_.ChooseSize(plan.is_coarse);
    views_.DecideOnCamerasWhereDue(plan.span, &*state_);
    const double begin = session_.Seconds();
    const double cost = views_.Step(plan, degree, &*state_);
    const int it = ++state_->iteration;
    state_->span = plan.span;
    state_->mean_cost = it == 1 ? cost : 0.95 * state_->mean_cost + 0.05 * cost;
    rollback_point_.ForgetWhatHolds(it);
    if (state_->averages && session_.schedule().Averages(plan.span, it)) Average();
    outlook_.ObserveIteration(views_.are_coarse(), state_->model.count(), views_.pixels(), session_.Seconds() - begin);
  }
  // The mean is an improvement; for want of its room training does not end.
  void Average() {
    try {
      state_->model.Average();
    } catch (const OutOfDeviceMemory& error) {
      state_->averages = false;
      session_.Note(notes::kAdamWithoutMean, error.what());
    }
  }

  // Whether the stage is to stop; the last row is of what it leaves.
  bool RecordWhereDue(const IterationPlan& plan) {
    const double ahead = outlook_.EvaluationSeconds();
    const bool is_stopped = session_.early_end().ShouldStop(ahead);
    const bool is_end = plan.span.is_last() || is_stopped;
    if (is_end || (plan.is_recorded && session_.time().HasTimeToRecord(ahead))) Record();
    return is_stopped;
  }
  void Record() {
    const int degree = DegreeOf(session_.schedule().At(state_->span));
    const splat::Model<float> result = state_->model.result(degree);
    const auto on_host = [&] { return OnHost(result); };
    views_.LendPhotographs();
    const auto evaluate = [&] {
      return EvaluateOrDownload(
          session_, views_.copies(), [&] { return result; }, views_.workspace(), on_host);
    };
    session_.history().Record(Stage::kAdam, state_->iteration, ModelToRecord{state_->model.count(), evaluate, on_host});
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

  void ChangeGaussians(const IterationPlan& plan, int degree) {
    if (plan.densifies) Densify();
    if (plan.resets_opacity) state_->model.ResetOpacity();
    pruning_.Thin(*state_, plan, degree, [&] {
      views_.LendPhotographs();
      views_.FreePasses();
      rollback_point_.Forget();  // of more than there are now
    });
  }
  void Densify() {
    const ScopedPhase phase("density");
    const Index before = state_->model.count();
    const double begin = session_.Seconds();
    views_.FreePasses();  // the new bases need room while the old ones are there
    state_->model.Densify(state_->iteration, [&] {
      if constexpr (!kOnHost) rollback_point_.Keep(*state_);
    });
    outlook_.ObserveGrowth(before, state_->model.count(), session_.Seconds() - begin);
  }

  // Tells what the whole stage will take.
  void PredictWhereDue(const IterationPlan& plan, int degree) {
    const auto telling = outlook_.WhatToTell(plan.observes);
    if (telling == StagePlanner::Telling::kNothing) return;
    const bool is_first_guess = telling == StagePlanner::Telling::kFirstGuess;
    if (!is_first_guess && views_.are_coarse()) {
      outlook_.pace().SetFullBeyondCoarse(views_.MeasureFullBeyondCoarse(degree, &state_->model));
    }
    const RemainingWork ahead = outlook_.Ahead(Progress());
    session_.Predict(outlook_.Foretell(Progress(), ahead, is_first_guess, PredictMib(degree, ahead.most_gaussians)));
  }
  double PredictMib(int degree, double gaussians) {
    const MemoryScene now = session_.memory().Count(OnHost(state_->model.kernel_model(degree)), 8, false);
    const MemoryScene then = now.Scaled(static_cast<Index>(gaussians));
    if constexpr (kOnHost) {
      return session_.plan().held_mib + PredictedMib(then, options_, 0);
    } else {
      return PredictedDeviceMib(then, options_, 0, session_.memory().kept_on_device());
    }
  }

  TrainingSession& session_;
  const TrainOptions& options_;
  SplatModel& result_;
  std::optional<std::string_view> saved_;  // to begin from
  std::optional<AdamStageState<B>> state_;
  StageViews<B> views_{session_};
  RollbackPoint<B> rollback_point_{session_};
  StagePlanner outlook_{session_};
  StagePruning<B> pruning_{session_, outlook_.pace()};
  int recorded_ = 0;
  bool finished_ = false;
};

// The whole stage; leaves the model at its best and records its last state. Where the memory of a device does not
// suffice it goes on with fewer Gaussians, ends, or runs on the host, and says so in a note.
template <class B>
void RunAdamStage(TrainingSession& session, SplatModel& model) {
  for (auto stage = std::make_unique<AdamStage<B>>(session, model);;) {
    try {
      return stage->Run();
    } catch (const OutOfDeviceMemory& error) {
      const int failed = stage->iteration();
      if (stage->RollBack()) {
        session.Note(notes::kAdamGoesBack, stage->iteration(), stage->gaussians(), error.what());
      } else if (failed > 0) {
        session.Note(notes::kAdamEnds, failed, error.what());
        return stage->Finish();
      } else {
        session.Note(notes::kAdamOnCpu, error.what());
        stage->GiveBackSavedStage();
        stage.reset();
        return RunAdamStage<CpuBackend<float>>(session, model);
      }
    }
  }
}

extern template void RunAdamStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
