// SPDX-License-Identifier: Apache-2.0
// The history of a training, its time limit, and the conditions that end it early.
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

using ModelOnHost = std::function<splat::Model<float>()>;

// Functions that evaluate a model to record, or copy it to host memory.
struct ModelToRecord {
  Index gaussians = 0;
  std::function<Evaluation()> evaluate;
  ModelOnHost on_host;  // called only if a callback needs it
};

// The history rows of a training, and their evaluations.
class RecordedHistory {
 public:
  // All arguments must outlive this object.
  RecordedHistory(const TrainingCameras& cameras, const TrainOptions& options, const TrainCallbacks& callbacks,
                  TrainingClock& clock)
      : cameras_(cameras),
        callbacks_(callbacks),
        clock_(clock),
        measured_{options.evaluated_views, ProcessGroup(callbacks.ranks)},
        renderer_(options.background, NearPlane(cameras.scene())) {}

  const MeasuredViews& measured_views() const { return measured_; }
  // Evaluates a model in host memory.
  Evaluation Evaluate(const splat::Model<float>& model) {
    return renderer_.Evaluate(model, cameras_.scene(), measured_);
  }
  // Evaluates the model while the clock is paused, and adds a row. Collective.
  void Record(Stage stage, int iteration, const ModelToRecord& model);
  // Records a model in host memory.
  void Record(Stage stage, int iteration, const splat::Model<float>& model) {
    Record(stage, iteration, {model.count, [&] { return Evaluate(model); }, [&] { return model; }});
  }
  // Predicted seconds of the next evaluation, from the latest one. Before the first evaluation, an estimate from
  // `seconds_per_pixel`, the training time per pixel; 0 if that is 0 (unknown).
  double SecondsAhead(double seconds_per_pixel) const;

  bool empty() const { return rows_.empty(); }
  // Whether the last row belongs to this stage.
  bool ends_with(Stage stage) const { return !empty() && rows_.back().stage == stage; }
  // PSNR of the latest row, dB; 0 without rows. A training has training views; held_out_psnr() is 0 without such views.
  double training_psnr() const { return empty() ? 0 : rows_.back().train.psnr; }
  double held_out_psnr() const { return empty() ? 0 : rows_.back().held_out.psnr; }

  const std::vector<HistoryRow>& rows() const { return rows_; }
  // Restores the rows of a resumed training.
  void Restore(std::vector<HistoryRow> rows) { rows_ = std::move(rows); }
  std::vector<HistoryRow> Take() { return std::move(rows_); }

 private:
  const TrainingCameras& cameras_;
  const TrainCallbacks& callbacks_;
  TrainingClock& clock_;
  MeasuredViews measured_;
  Renderer renderer_;
  std::vector<HistoryRow> rows_;
  double latest_seconds_ = 0;  // of one evaluation; 0: none yet
};

// Divides the time limit (TrainOptions::time_limit), which includes evaluations, among the parts of a training.
class TimeBudget {
 public:
  // All arguments must outlive this object.
  TimeBudget(const TrainOptions& options, const ProcessGroup& processes, const TrainingClock& clock)
      : options_(options), processes_(processes), clock_(clock) {}

  bool is_limited() const { return options_.time_limit > 0; }
  // Whether there is time for a history row that takes `seconds`: all rows but the last may together take a twentieth
  // of the time so far. Always true without a limit. Collective.
  bool HasTimeToRecord(double seconds) const;
  // Includes the stage's last evaluation; infinity without a limit.
  double SecondsForAdam() const;

 private:
  const TrainOptions& options_;
  const ProcessGroup& processes_;
  const TrainingClock& clock_;
};

// Conditions that end a training early: the caller's request, the time limit, or the target PSNR.
class EarlyEnd {
 public:
  // All arguments must outlive this object.
  EarlyEnd(const TrainOptions& options, const TrainCallbacks& callbacks, const ProcessGroup& processes,
           const TrainingClock& clock, const RecordedHistory& history)
      : options_(options), callbacks_(callbacks), processes_(processes), clock_(clock), history_(history) {}

  // True if the caller of any process requests a stop, or if rank 0's clock, with evaluations, plus `ahead` reaches the
  // time limit. ahead: seconds of the next work, which cannot be interrupted. Stays true. Collective.
  bool ShouldStop(double ahead = 0);
  bool stopped() const { return stopped_; }

  // has_reached_target: the held-out PSNR of the latest row is at least the target. misses_target: there is a target
  // that is not reached.
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
