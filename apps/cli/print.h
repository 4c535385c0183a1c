// SPDX-License-Identifier: Apache-2.0
// What the program prints: text, figures, and the progress line of a training with the time that is left.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// What cannot be written (a full disk) is no reason to lose what is computed: it is noted, and told by PrintError.
void PrintText(std::FILE* out, std::string_view text);

// From here on nothing more goes to stdout.
void BeQuiet();

// To stdout.
template <class... Args>
void Print(fmt::format_string<Args...> format, Args&&... args) {
  PrintText(stdout, fmt::format(format, std::forward<Args>(args)...));
}

// After all has been printed: why some of it could not be written to stdout, a line; else empty. That nobody reads it
// any more is no error.
std::string PrintError();

// A figure of quality, dB or SSIM, with so many digits: "exact" where images are equal to the last bit and it has no
// end, "-" where there is none.
std::string Figure(double value, int digits);
// A difference of two, with its sign.
std::string Gain(double difference, int digits);

// One line that a terminal can bear: without control characters, and of an overlong text both ends.
std::string OneLine(std::string_view text);

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

// The line that shows how a training goes. On a terminal one line with a bar, rewritten a few times a second. Elsewhere
// a line for every 5 % of a stage, and after 10 s without one, so each of a few LM iterations has its own.
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
