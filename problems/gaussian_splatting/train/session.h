// What both stages of a training run share: the views, the clock without evaluation, the history.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/train/over_ranks.h"
#include "problems/gaussian_splatting/train/trainer.h"
#include "problems/gaussian_splatting/train/training_cameras.h"

namespace vesta::gs {

// Seconds of the training, those before a break that it went on from included: a clock that has gone for `before`
// seconds, and stood still for `paused`, and stands still while an evaluation runs.
class TrainingClock {
 public:
  TrainingClock(double before, double paused) : start_(Now() - before - paused), paused_(paused) {}
  double Seconds() const { return Now() - start_ - paused_; }
  // With the time that it has stood still.
  double Total() const { return Now() - start_; }
  // Time the clock has stood still.
  double Paused() const { return paused_; }

  class Pause {
   public:
    explicit Pause(TrainingClock& clock) : clock_(clock), begin_(Now()) {}
    ~Pause() { clock_.paused_ += Now() - begin_; }
    Pause(const Pause&) = delete;
    Pause& operator=(const Pause&) = delete;

   private:
    TrainingClock& clock_;
    double begin_;
  };
  // Time that is none of the run's.
  class Absence {
   public:
    explicit Absence(TrainingClock& clock) : clock_(clock), begin_(Now()) {}
    ~Absence() { clock_.start_ += Now() - begin_; }
    Absence(const Absence&) = delete;
    Absence& operator=(const Absence&) = delete;

   private:
    TrainingClock& clock_;
    double begin_;
  };

 private:
  static double Now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  double start_, paused_;
};

// A model for the history, in whatever memory it is.
struct ModelToRecord {
  Index gaussians = 0;
  std::function<Evaluation()> evaluate;
  // The model in the memory of the host, for who looks at it. Asked for only then.
  std::function<splat::Model<float>()> on_host;
};

// Writes the state of a stage; and what comes before it where others have a part of that: told who saves, by process.
using WriteState = std::function<void(ArchiveWriter&)>;
using BeforeSaving = std::function<void(const std::vector<bool>& savers)>;

class TrainingSession {
 public:
  // Made by all of several processes together.
  TrainingSession(const Scene& scene, const TrainOptions& options, double seconds_before,
                  const TrainCallbacks& callbacks)
      : cameras_(scene, options.cameras, OwnViewsInAdam(options, callbacks.ranks, NumTrainingViews(scene))),
        fingerprint_(FingerprintOf(scene)),
        options_(options),
        callbacks_(callbacks),
        clock_(seconds_before + (callbacks.resume ? callbacks.resume->run.seconds : 0),
               callbacks.resume ? callbacks.resume->run.eval_seconds : 0),
        renderer_(options.background, NearPlane(scene)) {
    mask_bytes_ = MostOfAll(OwnMaskBytes());
    if (callbacks.resume) Resume(*callbacks.resume);
    any_saves_ = OnAny(saves());
  }

  // With the training views' cameras and exposures as they have been found.
  const Scene& scene() const { return cameras_.scene(); }
  const TrainOptions& options() const { return options_; }
  // For who cannot do what was asked for; all that comes later goes by it.
  TrainOptions& AdaptOptions() { return options_; }
  const std::vector<const View*>& training_views() const { return cameras_.views(); }
  // Of Adam's, that look at as many views as there are to train on.
  double IterationsPerEpoch() const {
    return static_cast<double>(training_views().size()) / options_.adam.views_per_iteration;
  }
  // By which memory of a stage is planned: as many as the process looks at that holds the most.
  std::vector<const View*> PlannedViews(Stage stage) const {
    return LargestShare(training_views(), stage == Stage::kAdam && AllTrainOnEach(options_) ? nullptr : ranks());
  }
  // Sizes that memory is planned by, of this model and PlannedViews(stage). most, with_entries: as in
  // memory/memory_scene.h.
  MemoryScene CountMemory(const splat::Model<float>& model, Stage stage, int most, bool with_entries) const;
  TrainingCameras& cameras() { return cameras_; }
  const TrainingCameras& cameras() const { return cameras_; }
  double Seconds() const { return clock_.Seconds(); }
  // With evaluation.
  double TotalSeconds() const { return clock_.Total(); }
  // Of evaluations, since it was gone on with.
  double EvalSeconds() const { return clock_.Paused() - (callbacks_.resume ? callbacks_.resume->run.eval_seconds : 0); }
  // Whether the last row of the history is of this stage.
  bool ends_with(Stage stage) const { return !history_.empty() && history_.back().stage == stage; }
  bool has_history() const { return !history_.empty(); }
  double latest_psnr() const { return history_.empty() ? 0 : history_.back().train.psnr; }

  // By which rows of the history come about.
  MeasuredViews measured_views() const { return {options_.evaluated_views, ranks()}; }
  // Of a model in the memory of the host.
  Evaluation Evaluate(const splat::Model<float>& model) { return renderer_.Evaluate(model, scene(), measured_views()); }
  // Evaluates, with the clock stopped, and adds a row to the history.
  void Record(Stage stage, int iteration, const ModelToRecord& model) {
    HistoryRow row;
    row.stage = stage, row.iteration = iteration, row.gaussians = model.gaussians;
    row.seconds = clock_.Seconds();
    const double begin = clock_.Total();
    const TrainingClock::Pause pause(clock_);
    const Evaluation evaluation = model.evaluate();
    row.cost = evaluation.cost;
    row.train = evaluation.train, row.held_out = evaluation.held_out, row.test = evaluation.test;
    history_.push_back(row);
    if (callbacks_.evaluated) callbacks_.evaluated(row, model.on_host());
    latest_evaluation_ = clock_.Total() - begin;
  }
  // The same of a model in the memory of the host.
  void Record(Stage stage, int iteration, const splat::Model<float>& model) {
    Record(stage, iteration, {model.count, [&] { return Evaluate(model); }, [&] { return model; }});
  }
  void Report(const TrainProgress& progress) const {
    if (callbacks_.progress) callbacks_.progress(progress);
  }
  // Whether the state may be saved after an iteration, by this process and by any.
  bool saves() const {
    const CheckpointOptions& options = callbacks_.checkpoint;
    return !options.path.empty() && (!options.every.never() || callbacks_.watch.wants_checkpoint);
  }
  bool any_saves() const { return any_saves_; }
  // After each iteration: saves the state of the stage where that is due, or is asked for, or where a training that
  // saves at intervals stops; state: writes it. An older checkpoint stays until the new one is complete, and where that
  // cannot be written. before: called first where any saves. Given by all of several processes or by none: they agree
  // on it, and may exchange in it.
  void SaveWhereDue(Stage stage, int iteration, const WriteState& state, const BeforeSaving& before = {});
  // At the end of an iteration that others follow: does what the watch asks for, and waits as long as it does. state:
  // empty where other processes have a part of it; then a checkpoint is written after the next iteration.
  void AttendToWatch(Stage stage, int iteration, const std::function<splat::Model<float>()>& on_host,
                     const WriteState& state);
  // Hands out the model on the way, where that is due. on_host: gives it.
  void SnapshotWhereDue(Stage stage, int iteration, const std::function<splat::Model<float>()>& on_host);
  // Processes that train together; null: this one alone.
  Ranks* ranks() const { return callbacks_.ranks; }
  // What one process decides by itself, as where its GPU has no room, others do not know of.
  bool trains_alone() const { return !ranks() || ranks()->size() == 1; }
  // Whether it is so in any of several processes. Called by all.
  bool OnAny(bool mine) const { return ranks() ? OnAnyRank(*ranks(), mine) : mine; }
  // The most that one says, by which all plan. Called by all.
  double MostOfAll(double mine) const {
    return trains_alone() ? mine : std::ranges::max(GatherValues(*ranks(), std::vector{mine}));
  }
  // What the first of several processes says, where each would say something else, as by its clock. Called by all.
  double OfFirst(double mine) const { return trains_alone() ? mine : GatherValues(*ranks(), std::vector{mine})[0]; }
  // The stage that a resumed training was in, Adam's where nothing is resumed; and how many iterations of it are done.
  Stage first_stage() const { return callbacks_.resume ? callbacks_.resume->run.stage : Stage::kAdam; }
  int first_iteration() const { return callbacks_.resume ? callbacks_.resume->iteration() : 0; }
  const std::optional<std::string>& saved_stage() const { return saved_stage_; }
  // The state of this stage that was saved, once; none where the stage begins anew.
  std::optional<std::string> TakeSavedStage(Stage stage);
  // For another to take.
  void GiveBackSavedStage(std::optional<std::string> saved) { saved_stage_ = std::move(saved); }
  // Where it cannot be one: throws Error, which names the checkpoint, and why where that is known; so does reading it
  // where that fails.
  [[noreturn]] void RefuseSavedStage(const std::string& why = "") const;
  template <class Read>
  auto ReadSavedStage(const Read& read) const {
    try {
      return read();
    } catch (const OutOfDeviceMemory&) {
      throw;
    } catch (const OthersGaveUp&) {
      throw;
    } catch (const Error& error) {
      RefuseSavedStage(error.what());
    }
  }

  // What the memory of a GPU has beyond all that the Adam stage was planned to take; and the most that was kept there
  // of what is otherwise copied to the host.
  double spare_device_bytes() const { return spare_device_bytes_; }
  void SetSpareDeviceBytes(double bytes) { spare_device_bytes_ = bytes; }
  void NoteKeptOnDevice(double bytes) { kept_on_device_ = std::max(kept_on_device_, bytes); }
  double kept_on_device() const { return kept_on_device_; }

  // The largest model there was so far, beside the one that a stage gives back: those before Gaussians were taken out.
  void NoteModel(const splat::ModelLayout& layout) {
    if (layout.Size() > largest_model_.Size()) largest_model_ = layout;
  }
  const splat::ModelLayout& largest_model() const { return largest_model_; }

  // A line for the user on what is done otherwise than asked for; once, though a training that goes on says it again.
  void Note(std::string line) {
    if (std::ranges::find(notes_, line) == notes_.end()) notes_.push_back(std::move(line));
  }
  std::vector<std::string> TakeNotes() { return std::move(notes_); }
  // Seconds that the next evaluation will take: as many as the latest. Before the first, by how fast views are trained
  // on; 0: not known.
  double EvaluationAhead(double seconds_per_pixel) const;
  // Whether there is time for a row of the history that is not the last: under a time limit a twentieth of the time
  // may go into such. Called by all.
  bool HasTimeToRecord(double ahead) const {
    if (options_.time_limit <= 0) return true;
    return OfFirst(clock_.Paused() + ahead <= 0.05 * (clock_.Total() + ahead) ? 1 : 0) > 0;
  }
  // Seconds that are left for the Adam stage, where time is limited; else more than any.
  double SecondsForAdam(double seconds_per_pixel) const;
  // True when the caller or the time limit asks to stop, of any of several processes; stays true. Called by all. ahead:
  // seconds that are still to be spent, on what cannot be broken off.
  bool ShouldStop(double ahead = 0) {
    if (options_.time_limit > 0 && clock_.Total() + ahead >= options_.time_limit) stopped_ = true;
    if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
    return stopped_ = OnAny(stopped_);
  }
  bool stopped() const { return stopped_; }
  // Of the latest row; 0: there are no such views.
  double held_out_psnr() const { return history_.empty() ? 0 : history_.back().held_out.psnr; }
  // Whether the views held out have come to what was asked for, by the latest row.
  bool has_reached_target() const { return options_.target_psnr > 0 && held_out_psnr() >= options_.target_psnr; }

  void Predict(const Prediction& prediction) {
    predictions_.push_back(prediction);
    if (callbacks_.predicted) callbacks_.predicted(prediction);
  }
  std::vector<Prediction> TakePredictions() { return std::move(predictions_); }
  std::vector<HistoryRow> TakeHistory() { return std::move(history_); }

 private:
  // When something is due that is done at intervals.
  class Timer {
   public:
    explicit Timer(double seconds) : last_seconds_(seconds) {}
    bool IsDue(const Interval& interval, Stage stage, int iteration, double seconds);

   private:
    double last_seconds_;
  };
  // seconds: of the run.
  void Save(Stage stage, int iteration, double seconds, const WriteState& state);
  // Writes what is written on the way; where that fails it says so in a note. Returns that note, else nothing.
  std::string NoteError(const char* what, const std::function<void()>& write);
  // Of the photographs in memory that this process trains on.
  double OwnMaskBytes() const;
  // Throws Error where the checkpoint is of another scene.
  void Resume(const Checkpoint& checkpoint);

  TrainingCameras cameras_;
  std::uint64_t fingerprint_;  // of the scene as it was given
  TrainOptions options_;
  const TrainCallbacks& callbacks_;
  TrainingClock clock_;
  Renderer renderer_;
  std::vector<HistoryRow> history_;
  std::vector<std::string> notes_;
  std::vector<Prediction> predictions_;
  // From where the training goes on.
  Timer checkpoint_timer_{callbacks_.resume ? callbacks_.resume->run.seconds : 0};
  Timer snapshot_timer_ = checkpoint_timer_;
  std::optional<std::string> saved_stage_;
  double mask_bytes_ = 0;         // OwnMaskBytes of the process with the most
  double latest_evaluation_ = 0;  // seconds; 0: none yet
  bool stopped_ = false, any_saves_ = false;
  double spare_device_bytes_ = 0, kept_on_device_ = 0;
  splat::ModelLayout largest_model_;
};

// LengthUnits by the training views; the scene's extent where none of them sees a Gaussian.
std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model);

}  // namespace vesta::gs
