// What both stages of a training run share: the views, the clock without evaluation, the history.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::gs {

// Seconds of the run: a clock that started `before` seconds ago and stands still while an evaluation runs.
class TrainingClock {
 public:
  explicit TrainingClock(double before) : start_(Now() - before) {}
  double Seconds() const { return Now() - start_ - paused_; }
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

 private:
  static double Now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  double start_;
  double paused_ = 0;
};

// A model for the history, in whatever memory it is.
struct ModelToRecord {
  Index gaussians = 0;
  std::function<Evaluation()> evaluate;
  // The model in the memory of the host, for who looks at it. Asked for only then.
  std::function<splat::Model<float>()> on_host;
};

class TrainingSession {
 public:
  TrainingSession(const Scene& scene, const TrainOptions& options, double seconds_before,
                  const TrainCallbacks& callbacks)
      : scene_(scene),
        options_(options),
        callbacks_(callbacks),
        clock_(seconds_before),
        renderer_(options.background, NearPlane(scene)) {
    for (const View& view : scene.views) {
      if (!view.is_test) training_views_.push_back(&view);
    }
  }

  const Scene& scene() const { return scene_; }
  const TrainOptions& options() const { return options_; }
  const std::vector<const View*>& training_views() const { return training_views_; }
  double Seconds() const { return clock_.Seconds(); }
  double EvalSeconds() const { return clock_.Paused(); }
  bool has_history() const { return !history_.empty(); }
  double latest_psnr() const { return history_.empty() ? 0 : history_.back().train.psnr; }
  double latest_cost() const { return history_.empty() ? 0 : history_.back().cost; }

  // Of a model in the memory of the host.
  Evaluation Evaluate(const splat::Model<float>& model) { return renderer_.Evaluate(model, scene_); }
  // Evaluates, with the clock stopped, and adds a row to the history.
  void Record(Stage stage, int iteration, const ModelToRecord& model) {
    HistoryRow row;
    row.seconds = clock_.Seconds();
    const TrainingClock::Pause pause(clock_);
    const Evaluation evaluation = model.evaluate();
    row.stage = stage, row.iteration = iteration, row.cost = evaluation.cost;
    row.train = evaluation.train, row.test = evaluation.test, row.gaussians = model.gaussians;
    history_.push_back(row);
    if (callbacks_.evaluated) callbacks_.evaluated(row, model.on_host());
  }
  // The same of a model in the memory of the host.
  void Record(Stage stage, int iteration, const splat::Model<float>& model) {
    Record(stage, iteration, {model.count, [&] { return Evaluate(model); }, [&] { return model; }});
  }
  void Report(const TrainProgress& progress) const {
    if (callbacks_.progress) callbacks_.progress(progress);
  }
  // A line for the user on what is done otherwise than asked for.
  void Note(std::string line) { notes_.push_back(std::move(line)); }
  std::vector<std::string> TakeNotes() { return std::move(notes_); }
  // True when the caller or the time limit asks to stop; stays true.
  bool ShouldStop() {
    if (options_.time_limit > 0 && clock_.Seconds() >= options_.time_limit) stopped_ = true;
    if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
    return stopped_;
  }
  bool stopped() const { return stopped_; }
  std::vector<HistoryRow> TakeHistory() { return std::move(history_); }

 private:
  const Scene& scene_;
  const TrainOptions& options_;
  const TrainCallbacks& callbacks_;
  TrainingClock clock_;
  Renderer renderer_;
  std::vector<const View*> training_views_;
  std::vector<HistoryRow> history_;
  std::vector<std::string> notes_;
  bool stopped_ = false;
};

// LengthUnits by the training views; the scene's extent where none of them sees a Gaussian.
std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model);

// The views to fit, for the operators; they must outlive what is returned.
std::vector<TargetView<CpuBackend<float>>> TargetsOf(const std::vector<const View*>& views, double near);

// The two stages; both leave the model at its best and record their last state.
void RunAdamStage(TrainingSession& session, SplatModel& model);
// Returns the engine's full report. hold_batches: as vesta::LmOptions has it.
std::string RunLmStage(TrainingSession& session, SplatModel& model, bool hold_batches);

}  // namespace vesta::gs
