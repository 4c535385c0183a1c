// SPDX-License-Identifier: Apache-2.0
// The history of a training, and what ends the training early: its caller, a time limit, a target.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "splatting/distributed/process_group.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/training_cameras.h"
#include "splatting/train/session/training_clock.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Gives the model in the memory of the host.
using ModelOnHost = std::function<splat::Model<float>()>;

// A model for the history, in whatever memory it is.
struct ModelToRecord {
  Index gaussians = 0;
  std::function<Evaluation()> evaluate;
  ModelOnHost on_host;  // for who looks at it; asked for only then
};

// The rows of a training's history, and the evaluations that they come from.
class RecordedHistory {
 public:
  // All must outlive this.
  RecordedHistory(const TrainingCameras& cameras, const TrainOptions& options, const TrainCallbacks& callbacks,
                  TrainingClock& clock)
      : cameras_(cameras),
        callbacks_(callbacks),
        clock_(clock),
        measured_{options.evaluated_views, ProcessGroup(callbacks.ranks)},
        renderer_(options.background, NearPlane(cameras.scene())) {}

  // By which rows come about.
  const MeasuredViews& measured_views() const { return measured_; }
  // Of a model in the memory of the host.
  Evaluation Evaluate(const splat::Model<float>& model) {
    return renderer_.Evaluate(model, cameras_.scene(), measured_);
  }
  // Evaluates, with the clock stopped, and adds a row.
  void Record(Stage stage, int iteration, const ModelToRecord& model);
  // The same of a model in the memory of the host.
  void Record(Stage stage, int iteration, const splat::Model<float>& model) {
    Record(stage, iteration, {model.count, [&] { return Evaluate(model); }, [&] { return model; }});
  }
  // Seconds that the next evaluation will take: as many as the latest. Before the first, by how fast views are trained
  // on; 0: not known.
  double SecondsAhead(double seconds_per_pixel) const;

  bool empty() const { return rows_.empty(); }
  // Whether the last row is of this stage.
  bool ends_with(Stage stage) const { return !empty() && rows_.back().stage == stage; }
  // Of the latest row; 0: there is none, or there are no such views.
  double training_psnr() const { return empty() ? 0 : rows_.back().train.psnr; }
  double held_out_psnr() const { return empty() ? 0 : rows_.back().held_out.psnr; }

  const std::vector<HistoryRow>& rows() const { return rows_; }
  // Those of before a break.
  void Restore(std::vector<HistoryRow> rows) { rows_ = std::move(rows); }
  std::vector<HistoryRow> Take() { return std::move(rows_); }

 private:
  const TrainingCameras& cameras_;
  const TrainCallbacks& callbacks_;
  TrainingClock& clock_;
  MeasuredViews measured_;
  Renderer renderer_;
  std::vector<HistoryRow> rows_;
  double latest_seconds_ = 0;  // of an evaluation; 0: none yet
};

// What a time limit leaves for what. It is of all time, evaluation included.
class TimeBudget {
 public:
  // All must outlive this.
  TimeBudget(const TrainOptions& options, const ProcessGroup& processes, const TrainingClock& clock)
      : options_(options), processes_(processes), clock_(clock) {}

  bool is_limited() const { return options_.time_limit > 0; }
  // Whether there is time for a row of the history that is not the last, which takes so many seconds: under a time
  // limit a twentieth of the time may go into such. Collective.
  bool HasTimeToRecord(double seconds) const;
  // Seconds that are left for the Adam stage and the evaluation after it, where time is limited; else more than any.
  double SecondsForAdam() const;

 private:
  const TrainOptions& options_;
  const ProcessGroup& processes_;
  const TrainingClock& clock_;
};

// What ends a training before its iterations are done: its caller, its time limit, its target.
class EarlyEnd {
 public:
  // All must outlive this.
  EarlyEnd(const TrainOptions& options, const TrainCallbacks& callbacks, const ProcessGroup& processes,
           const TrainingClock& clock, const RecordedHistory& history)
      : options_(options), callbacks_(callbacks), processes_(processes), clock_(clock), history_(history) {}

  // True when the caller asks to stop, of any of several processes, or the time limit does, which is of all time by the
  // clock of the first process; stays true. Collective. ahead: seconds that are still to be spent, on what cannot be
  // broken off.
  bool ShouldStop(double ahead = 0);
  bool stopped() const { return stopped_; }

  // Whether the views held out have come to what was asked for, by the latest row of the history; and whether they
  // have not, where something was.
  bool has_reached_target() const { return has_target() && history_.held_out_psnr() >= options_.target_psnr; }
  bool misses_target() const { return has_target() && !has_reached_target(); }

 private:
  bool has_target() const { return options_.target_psnr > 0; }

  const TrainOptions& options_;
  const TrainCallbacks& callbacks_;
  const ProcessGroup& processes_;
  const TrainingClock& clock_;
  const RecordedHistory& history_;
  bool stopped_ = false;
};

}  // namespace vesta::gs
