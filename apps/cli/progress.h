// SPDX-License-Identifier: Apache-2.0
// The progress line of a training, with the time that is left.
#pragma once

#include <cstdio>
#include <string>

#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// How long a stage of training will still take, by how long it has taken so far.
class TimeLeft {
 public:
  // After an iteration. Returns seconds; NaN where nothing has been seen of the stage yet.
  double Observe(const gs::TrainProgress& progress);

 private:
  bool started_ = false;
  gs::Stage stage_ = gs::Stage::kAdam;
  int start_iteration_ = 0;  // of the stage, as far as it was seen
  double start_seconds_ = 0;
  double latest_seconds_ = 0;
};

// On a terminal one line with a bar, rewritten a few times a second. Elsewhere a line for every 5 % of a stage, and
// after 10 s without one, so each of a few LM iterations has its own.
class ProgressLine {
 public:
  explicit ProgressLine(std::FILE* out);

  void Update(const gs::TrainProgress& progress);
  // Ends the rewritten line; to be called before anything else is printed.
  void Finish();

 private:
  bool IsDue(const gs::TrainProgress& progress) const;

  std::FILE* out_;
  bool is_terminal_;
  bool line_open_ = false;
  bool started_ = false;
  TimeLeft time_left_;
  gs::TrainProgress printed_;  // latest
};

// "0:07", "12:30", "1:02:03".
std::string FormatDuration(double seconds);

}  // namespace vesta::app
