// When to leave Adam for Levenberg-Marquardt.
#pragma once

#include "problems/gaussian_splatting/train/options.h"

namespace vesta::gs {

// The work of one iteration of LM, in iterations of Adam on one view of full size. Counted, never timed, so that runs
// are the same to the bit: both stages visit the same splats at the same pixels, and what each pass takes for a visit
// is a fixed number (docs/results/2026-11-22-stage-switch.md).
double LmWork(const LmStageOptions& lm, Index training_views);

// Where the Adam stage ends. With adam.switch_to_lm=fixed after the iterations that were asked for. With
// adam.switch_to_lm=auto as soon as Adam lowers the cost more slowly, for its work, than an iteration of LM has to for
// another one to follow (LmStageOptions::min_gain), and at the latest after those iterations; the last part of what it
// then is cools down.
//
// Costs are compared over whole epochs, in which each view has its turn once, after densification and the coarse views.
class StageSwitch {
 public:
  StageSwitch(const TrainOptions& options, Index training_views);

  // The last iteration as far as is known.
  int end() const { return end_; }
  // After iteration `it`, whose views had this mean cost.
  void Observe(int it, double cost);

  // What was observed; the rest follows from the options.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(end_, last_, sum_, previous_, counted_);
  }

 private:
  void Restart() { sum_ = 0, previous_ = 0, counted_ = 0; }

  AdamOptions adam_;
  int begin_;          // the first iteration that counts
  int window_ = 0;     // iterations whose costs are summed; 0: the end is fixed
  double least_fall_;  // of one sum to the next, as a part of the former
  int end_, last_ = 0;
  double sum_ = 0, previous_ = 0;
  int counted_ = 0;
};

}  // namespace vesta::gs
