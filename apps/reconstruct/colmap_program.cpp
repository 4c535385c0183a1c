// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/colmap_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "apps/cli/child_process.h"
#include "apps/cli/process.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;

// Whether the help lists the option; "--Mapper.num" is not "--Mapper.num_threads".
bool Lists(std::string_view help, const std::string& name) {
  const std::string option = "--" + name;
  for (std::size_t at = help.find(option); at != help.npos; at = help.find(option, at + 1)) {
    const std::size_t end = at + option.size();
    const auto next = static_cast<unsigned char>(end < help.size() ? help[end] : ' ');
    if (std::isalnum(next) == 0 && next != '_' && next != '.') return true;
  }
  return false;
}

// The first listed name; empty if there is none. Names without a dot, such as database_path, are in all versions.
std::string ListedName(std::string_view help, const std::string& alternatives) {
  for (const std::string& name : schema::SplitAt(alternatives, '|')) {
    if (name.find('.') == name.npos || Lists(help, name)) return name;
  }
  return {};
}

// The count in the last line with one of the texts; `unknown` without such a line. COLMAP 3.8 writes "(N)" before it
// registers image N, later versions write "(num_reg_frames=N)" with the number so far.
std::size_t LastNumberIn(std::string_view text, const std::vector<std::string>& wanted, std::size_t unknown) {
  std::size_t last = text.npos;
  for (const std::string& each : wanted) {
    const std::size_t at = text.rfind(each);
    if (at != text.npos && (last == text.npos || at > last)) last = at;
  }
  if (last == text.npos) return unknown;
  std::string_view line = text.substr(last, text.substr(last).find('\n'));
  const std::size_t end = line.rfind(')');
  if (end == line.npos) return unknown;
  line = line.substr(0, end);
  const std::size_t digits = line.find_last_not_of("0123456789") + 1;
  std::size_t number = 0;
  if (std::from_chars(line.data() + digits, line.data() + line.size(), number).ec != std::errc()) return unknown;
  return number > 0 && line[digits - 1] == '(' ? number - 1 : number;
}

// Counts in the part of the log that has been written since the start.
class LogReader {
 public:
  LogReader(std::string log, const LogCounter& counter) : log_(std::move(log)), counter_(counter) {
    std::error_code ignored;  // a log that does not exist yet has no bytes
    const auto size = fs::file_size(log_, ignored);
    read_ = ignored ? 0 : static_cast<std::streamoff>(size);
  }

  void Poll() {
    constexpr double kInterval = 10;  // seconds
    if (!counter_.changed || SecondsSinceStart() - polled_ < kInterval) return;
    polled_ = SecondsSinceStart();
    const std::size_t before = count_;
    ReadLines();
    if (count_ != before) counter_.changed(count_);
  }

 private:
  // Leaves a line without an end for the next time. The buffer limits the memory; a longer line has no progress.
  void ReadLines() {
    constexpr std::size_t kBuffer = 1 << 16;
    std::ifstream file(log_, std::ios::binary);
    std::string text(kBuffer, '\0');
    while (file) {
      file.seekg(read_);
      file.read(text.data(), static_cast<std::streamsize>(kBuffer));
      const std::string_view got(text.data(), static_cast<std::size_t>(file.gcount()));
      const std::size_t end = got.rfind('\n');
      const std::size_t used = end != got.npos ? end + 1 : got.size() == kBuffer ? kBuffer : 0;
      if (used == 0) return;
      count_ = CountAfter(got.substr(0, used), counter_, count_);
      read_ += static_cast<std::streamoff>(used);
    }
  }

  std::string log_;
  const LogCounter& counter_;
  std::streamoff read_ = 0;
  std::size_t count_ = 0;
  double polled_ = SecondsSinceStart();
};

}  // namespace

std::size_t CountAfter(std::string_view lines, const LogCounter& counter, std::size_t count) {
  // The number begins again with each model that COLMAP tries.
  if (counter.is_numbered) return std::max(count, LastNumberIn(lines, counter.texts, count));
  for (const std::string& each : counter.texts) {
    for (std::size_t at = lines.find(each); at != lines.npos; at = lines.find(each, at + each.size())) ++count;
  }
  return count;
}

std::string FindColmap() { return RequireProgram("colmap", "colmap", "for the cameras of photographs"); }

ColmapProgram::ColmapProgram(std::string log, std::string work, Device device, int threads)
    : program_(FindColmap()), log_(std::move(log)), work_(std::move(work)), threads_(threads) {
  if (device == Device::kCpu) return;
  // COLMAP prints "with CUDA" or "without CUDA" below its version.
  const bool has_cuda = HelpOf({"help"}).find("with CUDA") != std::string::npos;
  if (device == Device::kCuda && !has_cuda) {
    Fail(kUnavailable, "--device=cuda: {} was built without CUDA; use --device=cpu", program_);
  }
  uses_gpu_ = device == Device::kCuda || (has_cuda && FileExists("/dev/nvidiactl"));
}

std::string ColmapProgram::HelpOf(const std::vector<std::string>& words) const {
  const std::string file = (fs::path(work_) / "help.txt").string();
  std::error_code ignored;
  fs::remove(file, ignored);
  ChildCommand command{.words = {program_}, .log = file};
  command.words.insert(command.words.end(), words.begin(), words.end());
  RunChild(command);  // the exit status for help differs between versions
  std::string help = ReadFile(file);
  fs::remove(file, ignored);
  return help;
}

bool ColmapProgram::TryRun(const std::string& command, const Options& options, const LogCounter& progress,
                           std::string* reason) const {
  const std::string help = HelpOf({command, "-h"});
  ChildCommand child{.words = {program_, command}, .log = log_};
  for (const auto& [alternatives, value] : options) {
    if (const std::string name = ListedName(help, alternatives); !name.empty()) {
      child.words.insert(child.words.end(), {"--" + name, value});
    }
  }
  LogReader reader(log_, progress);
  const ChildEnd end = RunChild(child, [&] { reader.Poll(); });
  *reason = Describe(end);
  return end.status == 0 && end.signal == 0;
}

void ColmapProgram::Run(const std::string& command, const Options& options, const LogCounter& progress) const {
  std::string reason;
  if (TryRun(command, options, progress, &reason)) return;
  Fail(kUnavailable, "colmap {} failed ({}); its messages are in {}", command, reason, log_);
}

}  // namespace vesta::app
