// SPDX-License-Identifier: Apache-2.0
// Prints texts, formatted numbers, and the progress of a training.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// Write errors on stdout, such as a full disk, do not end the run; PrintError reports them.
void PrintText(std::FILE* out, std::string_view text);

// Discards all further text for stdout (--quiet).
void DiscardStdout();

// Prints to stdout.
template <class... Args>
void Print(fmt::format_string<Args...> format, Args&&... args) {
  PrintText(stdout, fmt::format(format, std::forward<Args>(args)...));
}

// Flushes stdout and returns its first write error as one line; empty: none. Call it at the end. A closed pipe is not
// an error.
std::string PrintError();

// "exact" for infinity (PSNR of equal images), "-" for NaN (no value).
std::string Figure(double value, int digits);
// A difference of two figures with its sign; "-" if not finite.
std::string Gain(double difference, int digits);

// One line that is safe for a terminal: control characters become "?", and the middle of a text of more than 1000 bytes
// "[...]".
std::string OneLine(std::string_view text);

// The remaining time of a training stage: as the stage predicts it, otherwise from its mean time per iteration.
class TimeLeft {
 public:
  // Call it after each iteration. Returns the remaining seconds of the stage; NaN at first.
  double Observe(const gs::TrainProgress& progress);

 private:
  bool started_ = false;
  gs::Stage stage_ = gs::Stage::kAdam;
  int start_iteration_ = 0;  // first observed iteration of the stage
  double start_seconds_ = 0;
  double latest_seconds_ = 0;
};

// Prints the progress of a training. On a terminal, rewrites one line with a bar up to five times per second.
// Otherwise, prints a line after every 5 % of a stage and after iterations that end 10 s or more after the last line.
class ProgressLine {
 public:
  explicit ProgressLine(std::FILE* out);

  // Call it after each iteration.
  void Update(const gs::TrainProgress& progress);
  // Ends the line on a terminal, before other text.
  void Finish();

 private:
  bool IsDue(const gs::TrainProgress& progress) const;

  std::FILE* out_;
  bool is_terminal_;
  bool line_open_ = false;
  bool started_ = false;
  TimeLeft time_left_;
  gs::TrainProgress printed_;  // latest printed
};

// "0:07", "12:30" or "1:02:03"; "?" if not finite.
std::string FormatDuration(double seconds);

}  // namespace vesta::app
