// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "apps/cli/print.h"

namespace vesta::app {

double TimeLeft::Observe(const gs::TrainProgress& p) {
  if (!started_ || p.stage != stage_) {
    // The second stage begins where the first one ended; how long the first one's first iteration took is not known.
    start_iteration_ = started_ ? 0 : p.iteration;
    start_seconds_ = started_ ? latest_seconds_ : p.seconds;
    started_ = true;
    stage_ = p.stage;
  }
  latest_seconds_ = p.seconds;
  const int done = p.iteration - start_iteration_;
  if (done == 0) return NAN;
  return (p.seconds - start_seconds_) / done * (p.iterations - p.iteration);
}

namespace {

constexpr double kTerminalInterval = 0.2, kLogInterval = 10.0;  // seconds

// "1800/4000", as wide as it will be in the end.
std::string Count(const gs::TrainProgress& p) {
  return fmt::format("{:>{}}/{}", p.iteration, fmt::formatted_size("{}", p.iterations), p.iterations);
}

std::string FormatLine(const gs::TrainProgress& p, double seconds_left) {
  std::string line = fmt::format("{:<4} {}  cost {:.5f}", gs::StageName(p.stage), Count(p), p.cost);
  if (p.psnr > 0) line += "  PSNR " + Figure(p.psnr, 2);
  line += fmt::format("  {} Gaussians  {} left", p.gaussians, FormatDuration(seconds_left));
  if (!p.note.empty()) line += fmt::format("  {}", p.note);
  return line;
}

// What matters most comes first: a narrow terminal shows no more.
std::string FormatBar(const gs::TrainProgress& p, double seconds_left) {
  constexpr std::size_t kWidth = 24;
  const double part = p.iterations > 0 ? std::clamp(static_cast<double>(p.iteration) / p.iterations, 0.0, 1.0) : 1.0;
  const auto filled = static_cast<std::size_t>(part * kWidth);
  std::string line =
      fmt::format("{:<4} {:>3.0f} %  {} left  [{}{}]  {}", gs::StageName(p.stage), std::floor(100 * part),
                  FormatDuration(seconds_left), std::string(filled, '#'), std::string(kWidth - filled, '.'), Count(p));
  if (p.psnr > 0) line += "  PSNR " + Figure(p.psnr, 2);
  line += fmt::format("  {} Gaussians", p.gaussians);
  if (!p.note.empty()) line += fmt::format("  {}", p.note);
  return line;
}

// What fits on one line of the terminal: a longer one would wrap and could not be rewritten.
std::string CutToTerminal(const std::string& line, std::FILE* terminal) {
  winsize size{};
  const bool is_known = ::ioctl(::fileno(terminal), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return line.substr(0, is_known ? size.ws_col - 1u : 79u);
}

}  // namespace

ProgressLine::ProgressLine(std::FILE* out) : out_(out), is_terminal_(::isatty(::fileno(out)) == 1) {}

bool ProgressLine::IsDue(const gs::TrainProgress& p) const {
  if (p.iteration >= p.iterations) return true;
  const double since = p.seconds - printed_.seconds;
  if (is_terminal_) return since >= kTerminalInterval;
  const auto twentieth = [&](int iteration) { return 20 * static_cast<Index>(iteration) / p.iterations; };
  return since >= kLogInterval || twentieth(p.iteration) > twentieth(printed_.iteration);
}

void ProgressLine::Update(const gs::TrainProgress& p) {
  const bool is_new_stage = !started_ || p.stage != printed_.stage;
  const double seconds_left = time_left_.Observe(p);
  if (is_new_stage) Finish();
  started_ = true;
  if (!is_new_stage && !IsDue(p)) return;
  if (is_terminal_) {
    PrintText(out_, fmt::format("\r{}\033[K", CutToTerminal(FormatBar(p, seconds_left), out_)));
  } else {
    PrintText(out_, FormatLine(p, seconds_left) + "\n");
  }
  std::fflush(out_);
  line_open_ = is_terminal_;
  printed_ = p;
}

void ProgressLine::Finish() {
  if (line_open_) PrintText(out_, "\n");
  line_open_ = false;
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const auto whole = static_cast<long>(std::lround(std::max(seconds, 0.0)));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace vesta::app
