// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/print.h"

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

}  // namespace

void BeQuiet() { is_quiet = true; }

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

}  // namespace vesta::app
