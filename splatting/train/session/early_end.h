// What ends a training before its iterations are done: its caller, its time limit, its target.
#pragma once

#include "splatting/distributed/process_group.h"
#include "splatting/train/session/recorded_history.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/training_clock.h"
#include "splatting/train/settings/options.h"

namespace vesta::gs {

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
