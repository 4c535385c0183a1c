// The time of a training.
#pragma once

#include <chrono>

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

}  // namespace vesta::gs
