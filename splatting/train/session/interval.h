// What is done at intervals in the course of a training.
#pragma once

#include "splatting/train/session/history.h"

namespace vesta::gs {

// Every so many iterations, or minutes of the training's clock; both 0: never. Where iterations are given every one of
// LM's is due, since it takes as long as hundreds of Adam's; minutes count alike in both stages.
struct Interval {
  int iterations = 0;
  double minutes = 0;
  bool never() const { return iterations == 0 && minutes == 0; }
};

// When something is due that is done at intervals.
class IntervalTimer {
 public:
  // From so many seconds of the clock on.
  explicit IntervalTimer(double seconds) : last_seconds_(seconds) {}
  // After an iteration, with so many seconds on the clock.
  bool IsDue(const Interval& interval, Stage stage, int iteration, double seconds) {
    const bool by_iterations = interval.iterations > 0 && (stage == Stage::kLm || iteration % interval.iterations == 0);
    const bool by_time = interval.minutes > 0 && seconds - last_seconds_ >= 60 * interval.minutes;
    if (by_iterations || by_time) last_seconds_ = seconds;
    return by_iterations || by_time;
  }

 private:
  double last_seconds_;
};

}  // namespace vesta::gs
