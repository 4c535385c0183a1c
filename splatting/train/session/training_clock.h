// SPDX-License-Identifier: Apache-2.0
// The clock of a training, and timers for periodic work.
#pragma once

#include <chrono>

#include "splatting/train/session/train_result.h"

namespace vesta::gs {

// Interval in Adam iterations, in minutes of the training clock, or both; both 0: never. If `iterations` is set, every
// LM iteration is due, since it takes the time of hundreds of Adam iterations.
struct Interval {
  int iterations = 0;
  double minutes = 0;
  bool never() const { return iterations == 0 && minutes == 0; }
};

class IntervalTimer {
 public:
  // seconds: start on the training clock.
  explicit IntervalTimer(double seconds) : last_seconds_(seconds) {}
  // Call after each iteration. seconds: time of the training clock. If due, the minutes start again.
  bool IsDue(const Interval& interval, Stage stage, int iteration, double seconds) {
    const bool by_iterations = interval.iterations > 0 && (stage == Stage::kLm || iteration % interval.iterations == 0);
    const bool by_time = interval.minutes > 0 && seconds - last_seconds_ >= 60 * interval.minutes;
    if (by_iterations || by_time) last_seconds_ = seconds;
    return by_iterations || by_time;
  }

 private:
  double last_seconds_;
};

// Continues from an earlier run: `before` seconds of training, and `paused` seconds of evaluations. Paused while a
// Pause object exists.
class TrainingClock {
 public:
  TrainingClock(double before, double paused) : start_(Now() - before - paused), paused_(paused) {}
  // Seconds without pauses.
  double Seconds() const { return Now() - start_ - paused_; }
  // Including pauses.
  double Total() const { return Now() - start_; }
  // Seconds of all pauses.
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
  // While it exists, time counts neither as training nor as a pause.
  class ExcludedTime {
   public:
    explicit ExcludedTime(TrainingClock& clock) : clock_(clock), begin_(Now()) {}
    ~ExcludedTime() { clock_.start_ += Now() - begin_; }
    ExcludedTime(const ExcludedTime&) = delete;
    ExcludedTime& operator=(const ExcludedTime&) = delete;

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
