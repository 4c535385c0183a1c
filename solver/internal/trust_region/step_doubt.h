// What rejected steps say against convergence: after a step that was to gain much and did not, a shorter one that
// changes little says nothing of x.
#pragma once

#include <string>

namespace vesta {

class StepDoubt {
 public:
  // predicted: decrease of the cost by the model. finite: whether the cost of the trial was.
  void OnReject(double predicted, bool finite);
  void OnAccept() { *this = {}; }

  // What to suspect of the problem, beginning with "; ", of the steps rejected since the last accepted one; empty:
  // nothing. Decreases and increases up to `least` do not count: they may be rounding. accepted: for a step that was
  // accepted now, against which only steps to where the cost is not finite speak.
  std::string Words(bool accepted, double least) const;
  // The part of it that no step excuses.
  std::string IncreaseWords(double least) const;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(promised_, blocked_, increase_);
  }

 private:
  double promised_ = 0;  // the largest decrease predicted
  double blocked_ = 0;   // of a trial without a finite cost
  double increase_ = 0;  // the largest increase predicted
};

}  // namespace vesta
