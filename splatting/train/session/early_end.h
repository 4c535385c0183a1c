// SPDX-License-Identifier: Apache-2.0
// What ends a training before its iterations are done, and what a time limit leaves for each part.
#pragma once

#include "splatting/distributed/process_group.h"
#include "splatting/train/session/recorded_history.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/training_clock.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

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
