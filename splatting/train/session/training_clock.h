// SPDX-License-Identifier: Apache-2.0
// The time of a training, and what is done at intervals of it.
#pragma once

#include <chrono>

#include "splatting/train/session/train_result.h"

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

}  // namespace vesta::gs
