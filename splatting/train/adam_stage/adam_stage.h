// SPDX-License-Identifier: Apache-2.0
// The Adam stage: its iterations, and its reaction when a GPU runs out of memory.
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

// The state before the first iteration.
template <class B>
AdamStageState<B> StartAdam(const TrainingSession& session, const SplatModel& model) {
  const TrainOptions& options = session.options();
  // Learning rates and length units depend on the given cameras.
  const std::vector<const View*>& views = session.cameras().given();
  const Scene& scene = session.scene();
  DensityOptions density = options.density;
  density.max_gaussians = session.plan().max_gaussians;
  return {TrainedModel<B>(model, Adam<B>(options.lr, options.adam.second_moment, options.adam.batch_size),
                          DensityControl<typename B::Space>(density, scene.extent),
                          LengthUnitViews(views, NearPlane(scene)), scene.extent),
          ViewOrder(views.size(), options.seed, static_cast<std::size_t>(options.adam.batch_size))};
}

// Adam with densification and pruning, on one or a few views per iteration. Parameters, gradient and moments are in the
// memory of backend B.
template <class B>
class AdamStage {
 public:
  // model: the initial Gaussians; receives the result. Resumes from the session's saved Adam stage, if any.
  AdamStage(TrainingSession& session, SplatModel& model)
      : session_(session), options_(session.options()), result_(model), saved_(session.saved().Take(Stage::kAdam)) {}

  // Runs the remaining iterations. On a device it may throw OutOfDeviceMemory; RunAdamStage then calls RollBack, Finish
  // or GiveBackSavedStage.
  void Run() {
    if (!state_) Begin();
    views_.LoadFull();
    while (!finished_ && !state_->span.is_last() && !session_.early_end().stopped()) Iterate();
    if (!finished_) Finish();
  }

  int iteration() const { return state_ ? state_->iteration : 0; }
  // Returns the saved state to the session if the stage could not begin, so that another AdamStage can resume.
  void GiveBackSavedStage() { session_.saved().GiveBack(std::exchange(saved_, std::nullopt)); }
  Index gaussians() const { return state_->model.count(); }
  // Restores the state before the last densification; no Gaussians are added afterwards. Without such a state, returns
  // false and changes nothing.
  bool RollBack() {
    if (rollback_point_.empty()) return false;
    views_.FreePasses();
    if constexpr (!kOnHost) rollback_point_.Restore(&*state_);
    // The stored state is from before the opacity reset of that iteration.
    if (session_.schedule().At(state_->span).resets_opacity) state_->model.ResetOpacity();
    return true;
  }
  // Stores the model and records it in the history.
  void Finish() {
    views_.UpdateMovedCameras();
    if (recorded_ != state_->iteration) Record();
    pruning_.AddPruningNotes(*state_, state_->model.count());
    views_.FreePasses();
    state_->model.Finish(result_);
    finished_ = true;
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;

  void Begin() {
    state_.emplace(StartAdam<B>(session_, result_));
    if constexpr (kOnHost) result_.data = std::vector<float>();  // until the end of the stage, state_ holds the data
    if (saved_) Restore(*saved_);
    saved_.reset();
  }
  void Restore(std::string_view bytes) {
    try {
      ArchiveReader reader(bytes);
      session_.saved().Validate([&] { reader(*state_); });
    } catch (const OutOfDeviceMemory&) {
      state_.reset();  // the stage has not begun
      throw;
    }
    if (!state_->IsWhole() || !views_.IsState(state_->cameras)) session_.saved().Refuse();
    const int n = session_.schedule().iterations(), views = options_.adam.batch_size;
    if (state_->iteration >= n) {
      Fail(kBadArgument,
           "{}: {} Adam iterations are done, but only {} were requested; set a higher --iterations, or a --time_limit",
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
    const IterationPlan plan = session_.schedule().At(planner_.NextSpan(Progress()));
    const int degree = DegreeOf(plan);
    Step(plan, degree);
    // Evaluate before densification: directly after splitting, the image quality is lower.
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
    session_.interim().ServeViewer(Stage::kAdam, state_->iteration, on_host, Writer());
  }
  // Stops after this iteration, which is recorded already. The result is the model before the iteration's densification
  // and pruning; a checkpoint has the state after them. It has no notes about the end of the stage, because a resumed
  // run adds its own.
  void Stop(const IterationPlan& plan, int degree) {
    state_->model.DownloadResult(result_);
    finished_ = true;
    const Index gaussians = state_->model.count();
    if (session_.processes().OnAny(session_.interim().Saves())) ChangeGaussians(plan, degree);
    Report();
    Save();
    pruning_.AddPruningNotes(*state_, gaussians);
  }
  void Report() {
    session_.Report({Stage::kAdam, state_->iteration, planner_.ExpectedIterations(Progress()), session_.Seconds(),
                     state_->mean_cost, session_.history().training_psnr(), state_->model.count(), "",
                     planner_.SecondsLeft(Progress())});
  }
  void Save() { session_.interim().SaveWhereDue(Stage::kAdam, state_->iteration, Writer()); }
  WriteState Writer() {
    return [&](ArchiveWriter& archive) { archive(*state_); };
  }

  int DegreeOf(const IterationPlan& plan) const { return std::min(plan.max_sh_degree, state_->model.sh_degree()); }

  // The loss is summed, not averaged, over pixels and views: Adam's steps do not depend on its scale.
  void Step(const IterationPlan& plan, int degree) {
    views_.ChooseSize(plan.is_coarse);
    views_.DecideOnCamerasWhereDue(plan.span, &*state_);
    const double begin = session_.Seconds();
    const double cost = views_.Step(plan, degree, &*state_);
    state_->CountIteration(plan.span, cost);
    const int it = state_->iteration;
    rollback_point_.DropSnapshotIfMemoryLasts(it);
    if (state_->is_averaging && session_.schedule().Averages(plan.span, it)) Average();
    planner_.ObserveIteration(views_.are_coarse(), state_->model.count(), views_.pixels(), session_.Seconds() - begin);
  }
  // Adds the parameters to their average. If memory for the average is lacking, the stage continues without it.
  void Average() {
    try {
      state_->model.Average();
    } catch (const OutOfDeviceMemory& error) {
      state_->is_averaging = false;
      session_.Note(notes::kAdamWithoutMean, error.what());
    }
  }

  // Records a history row if due, or if the stage ends. Returns true if the stage must stop early.
  bool RecordWhereDue(const IterationPlan& plan) {
    const double ahead = planner_.EvaluationSeconds();
    const bool is_stopped = session_.early_end().ShouldStop(ahead);
    const bool is_end = plan.span.is_last() || is_stopped;
    if (is_end || (plan.is_recorded && session_.time().HasTimeToRecord(ahead))) Record();
    return is_stopped;
  }
  void Record() {
    const int degree = DegreeOf(session_.schedule().At(state_->span));
    const splat::Model<float> result = state_->model.result(degree);
    const auto on_host = [&] { return OnHost(result); };
    views_.ReleasePhotographs();
    const auto evaluate = [&] {
      return EvaluateOrDownload(
          session_, views_.copies(), [&] { return result; }, views_.workspace(), on_host);
    };
    session_.history().Record(Stage::kAdam, state_->iteration, ModelToRecord{state_->model.count(), evaluate, on_host});
    recorded_ = state_->iteration;
  }
  // A device model is downloaded into result_; the next download overwrites it.
  splat::Model<float> OnHost(const splat::Model<float>& result) {
    if constexpr (!kOnHost) {
      state_->model.DownloadResult(result_);
      return {result_.data.data(), result, result.active_sh_degree};
    } else {
      return result;
    }
  }

  void ChangeGaussians(const IterationPlan& plan, int degree) {
    const auto free_memory = [&] {
      views_.ReleasePhotographs();
      views_.FreePasses();
      rollback_point_.Discard();  // the copy has more Gaussians than the pruned model
    };
    const Index count_before = state_->model.count();
    pruning_.PrepareGrowth(*state_, plan, degree, free_memory);
    if (plan.densifies) Densify(count_before);
    if (plan.resets_opacity) state_->model.ResetOpacity();
    pruning_.Prune(*state_, plan, degree, free_memory);
  }
  // count_before: number of Gaussians before the pruning of the same iteration.
  void Densify(Index count_before) {
    const ScopedPhase phase("density");
    const double begin = session_.Seconds();
    views_.FreePasses();  // the new arrays must fit beside the old ones
    const double views = static_cast<double>(session_.training_views().size());
    const double epochs = static_cast<double>(state_->model.density().views()) / views;
    // The mean cost is over all pixels.
    const double price = GaussianPrice(state_->mean_cost / UnmaskedFraction(session_.training_views()), epochs);
    state_->model.Densify(price, [&] {
      if constexpr (!kOnHost) rollback_point_.Store(*state_);
    });
    planner_.ObserveGrowth(count_before, state_->model.count(), session_.Seconds() - begin);
  }

  // Predicts time and memory of the whole stage.
  void PredictWhereDue(const IterationPlan& plan, int degree) {
    const auto kind = planner_.NextForecast(plan.observes);
    if (kind == StagePlanner::ForecastKind::kNothing) return;
    const bool is_first_guess = kind == StagePlanner::ForecastKind::kFirstGuess;
    if (!is_first_guess && views_.are_coarse()) {
      planner_.timer().SetFullMinusCoarse(views_.MeasureFullMinusCoarse(degree, &state_->model));
    }
    const RemainingWork ahead = planner_.Ahead(Progress());
    session_.Predict(
        planner_.MakeForecast(Progress(), ahead, is_first_guess, PredictMib(degree, ahead.most_gaussians)));
  }
  double PredictMib(int degree, double gaussians) {
    const MemoryScene now = session_.memory().Count(OnHost(state_->model.kernel_model(degree)), 8, false);
    const MemoryScene then = now.Scaled(static_cast<Index>(gaussians));
    if constexpr (kOnHost) {
      return session_.plan().held_mib + PredictedMib(then, options_, 0);
    } else {
      return PredictedDeviceMib(then, options_, 0, session_.memory().device_snapshot_bytes());
    }
  }

  TrainingSession& session_;
  const TrainOptions& options_;
  SplatModel& result_;
  std::optional<std::string_view> saved_;  // state to resume from
  std::optional<AdamStageState<B>> state_;
  StageViews<B> views_{session_};
  RollbackPoint<B> rollback_point_{session_};
  StagePlanner planner_{session_};
  StagePruning<B> pruning_{session_, planner_.timer()};
  int recorded_ = 0;
  bool finished_ = false;
};

// Runs the whole stage, stores the model and records its last state. If a device runs out of memory, the stage
// continues with fewer Gaussians, ends, or restarts on the host, with a note.
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
