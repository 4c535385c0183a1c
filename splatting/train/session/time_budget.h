// What a time limit leaves for what. It is of all time, evaluation included.
#pragma once

#include "splatting/distributed/process_group.h"
#include "splatting/train/session/training_clock.h"
#include "splatting/train/settings/options.h"

namespace vesta::gs {

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

}  // namespace vesta::gs
