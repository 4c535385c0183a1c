// The line that shows how training goes.
#pragma once

#include <cstdio>
#include <string>

#include "apps/cli/time_left.h"
#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

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
