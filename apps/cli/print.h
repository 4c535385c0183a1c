// SPDX-License-Identifier: Apache-2.0
// Printing: text, formatted numbers, and the progress line of a training with its remaining time.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// Writes the text. A write error (a full disk) does not stop the run; PrintError reports it at the end.
void PrintText(std::FILE* out, std::string_view text);

// Discards all further output to stdout.
void DiscardStdout();

// Formats to stdout.
template <class... Args>
void Print(fmt::format_string<Args...> format, Args&&... args) {
  PrintText(stdout, fmt::format(format, std::forward<Args>(args)...));
}

// At the end of the program: the first write error of stdout as one line, or empty. A closed pipe is not an error.
std::string PrintError();

// Formats PSNR or SSIM: "exact" for infinity (equal images), "-" for NaN or minus infinity (no value).
std::string Figure(double value, int digits);
// Formats a difference of two such values with its sign.
std::string Gain(double difference, int digits);

// Makes the text one safe terminal line: replaces control characters, and shortens a long text in the middle.
std::string OneLine(std::string_view text);

// Estimates the remaining time of a training stage from its mean time per iteration.
class TimeLeft {
 public:
  // Call after each iteration. Returns seconds, or NaN before the first timed iteration of the stage.
  double Observe(const gs::TrainProgress& progress);

 private:
  bool started_ = false;
  gs::Stage stage_ = gs::Stage::kAdam;
  int start_iteration_ = 0;  // first observed iteration of the stage
  double start_seconds_ = 0;
  double latest_seconds_ = 0;
};

// Progress of a training. On a terminal: one line with a bar, rewritten a few times per second. Otherwise: a new line
// for every 5 % of a stage, or after 10 s, so each slow LM iteration has its own line.
class ProgressLine {
 public:
  explicit ProgressLine(std::FILE* out);

  void Update(const gs::TrainProgress& progress);
  // Ends the rewritten line. Call it before printing anything else.
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
