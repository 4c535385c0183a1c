// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/print.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <system_error>

namespace vesta::app {
namespace {

int stdout_error = 0;  // the first errno
bool is_quiet = false;

void NoteError(std::FILE* out, bool failed) {
  if (failed && out == stdout && stdout_error == 0 && errno != EPIPE) stdout_error = errno;
}

bool ContinuesCharacter(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }  // of UTF-8

constexpr double kTerminalInterval = 0.2, kLogInterval = 10.0;  // seconds

// "1800/4000", padded to its final width.
std::string Count(const gs::TrainProgress& p) {
  if (p.iterations == 0) return fmt::format("{}", p.iteration);
  return fmt::format("{:>{}}/{}", p.iteration, fmt::formatted_size("{}", p.iterations), p.iterations);
}

std::string FormatLine(const gs::TrainProgress& p, double seconds_left) {
  std::string line = fmt::format("{:<4} {}  training loss {:.5f}", gs::StageName(p.stage), Count(p), p.cost);
  if (p.psnr > 0) line += "  training PSNR " + Figure(p.psnr, 2);
  line += fmt::format("  {} Gaussians  {} left", p.gaussians, FormatDuration(seconds_left));
  if (!p.note.empty()) line += fmt::format("  {}", p.note);
  return line;
}

// The most important numbers come first: narrow terminals cut off the rest.
std::string FormatBar(const gs::TrainProgress& p, double seconds_left) {
  constexpr std::size_t kWidth = 24;
  const double part = p.iterations > 0 ? std::clamp(static_cast<double>(p.iteration) / p.iterations, 0.0, 1.0) : 0.0;
  const auto filled = static_cast<std::size_t>(part * kWidth);
  std::string line =
      fmt::format("{:<4} {:>3.0f} %  {} left  [{}{}]  {}", gs::StageName(p.stage), std::floor(100 * part),
                  FormatDuration(seconds_left), std::string(filled, '#'), std::string(kWidth - filled, '.'), Count(p));
  if (p.psnr > 0) line += "  training PSNR " + Figure(p.psnr, 2);
  line += fmt::format("  {} Gaussians", p.gaussians);
  if (!p.note.empty()) line += fmt::format("  {}", p.note);
  return line;
}

// Shortens the line to the terminal width: a wrapped line could not be rewritten.
std::string CutToTerminal(const std::string& line, std::FILE* terminal) {
  winsize size{};
  const bool is_known = ::ioctl(::fileno(terminal), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return line.substr(0, is_known ? size.ws_col - 1u : 79u);
}

}  // namespace

void DiscardStdout() { is_quiet = true; }

void PrintText(std::FILE* out, std::string_view text) {
  if (is_quiet && out == stdout) return;
  NoteError(out, std::fwrite(text.data(), 1, text.size(), out) != text.size());
}

std::string PrintError() {
  NoteError(stdout, std::fflush(stdout) != 0);
  if (stdout_error == 0) return {};
  return fmt::format("stdout: cannot be written: {}", std::generic_category().message(stdout_error));
}

std::string Figure(double value, int digits) {
  if (std::isfinite(value)) return fmt::format("{:.{}f}", value, digits);
  return value > 0 ? "exact" : "-";
}

std::string Gain(double difference, int digits) {
  return std::isfinite(difference) ? fmt::format("{:+.{}f}", difference, digits) : "-";
}

std::string OneLine(std::string_view text) {
  constexpr std::size_t kMost = 1000, kEnd = 400;
  std::string line(text);
  if (line.size() > kMost) {
    std::size_t cut = kMost - kEnd, rest = line.size() - kEnd;
    while (ContinuesCharacter(line[cut])) --cut;
    while (rest < line.size() && ContinuesCharacter(line[rest])) ++rest;
    line = line.substr(0, cut) + " [...] " + line.substr(rest);
  }
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(line.begin(), line.end(), is_control, '?');
  return line;
}

double TimeLeft::Observe(const gs::TrainProgress& p) {
  if (!started_ || p.stage != stage_) {
    // The second stage starts when the first one ends. The start of the first iteration is unknown.
    start_iteration_ = started_ ? 0 : p.iteration;
    start_seconds_ = started_ ? latest_seconds_ : p.seconds;
    started_ = true;
    stage_ = p.stage;
  }
  latest_seconds_ = p.seconds;
  if (std::isfinite(p.seconds_left)) return p.seconds_left;
  const int done = p.iteration - start_iteration_;
  if (done == 0 || p.iterations == 0) return NAN;
  return (p.seconds - start_seconds_) / done * (p.iterations - p.iteration);
}

ProgressLine::ProgressLine(std::FILE* out) : out_(out), is_terminal_(::isatty(::fileno(out)) == 1) {}

bool ProgressLine::IsDue(const gs::TrainProgress& p) const {
  if (p.iterations > 0 && p.iteration >= p.iterations) return true;
  const double since = p.seconds - printed_.seconds;
  if (is_terminal_) return since >= kTerminalInterval;
  const auto twentieth = [&](int iteration) { return 20 * static_cast<Index>(iteration) / std::max(p.iterations, 1); };
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
