// SPDX-License-Identifier: Apache-2.0
// The program `colmap`, version 3.8 or later.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"

namespace vesta::app {

// Throws Error, with the package to install, if there is no program `colmap`. Returns its file.
std::string FindColmap();

// The progress of a COLMAP command: the number of times that its messages contain one of the texts. If is_numbered,
// the number of registered images, as in "Registering image #7 (3)".
struct LogCounter {
  std::vector<std::string> texts;
  bool is_numbered = false;
  std::function<void(std::size_t count)> changed;  // called at most every 10 seconds
};

// The count after more lines of messages.
std::size_t CountAfter(std::string_view lines, const LogCounter& counter, std::size_t count);

class ColmapProgram {
 public:
  // log: file for all commands and messages; work: folder for temporary files. Both folders must exist. Device::kAuto
  // uses the GPU if COLMAP was built with CUDA and there is an NVIDIA driver. threads: per command. Throws Error like
  // FindColmap; and for Device::kCuda if COLMAP was built without CUDA.
  ColmapProgram(std::string log, std::string work, Device device, int threads);

  // A name and its value. The name may have alternatives, separated by bars.
  using Options = std::vector<std::pair<std::string, std::string>>;

  // Runs "colmap COMMAND --NAME VALUE ...". Versions of COLMAP differ in the names with a dot, such as
  // SiftExtraction.use_gpu, which became FeatureExtraction.use_gpu. The first alternative that `colmap COMMAND -h`
  // lists is given; without one, COLMAP's default applies. Throws Error, with the log, if the command fails.
  void Run(const std::string& command, const Options& options, const LogCounter& progress = {}) const;

  // As above, but returns false, with the reason, if the command fails.
  bool TryRun(const std::string& command, const Options& options, const LogCounter& progress,
              std::string* reason) const;

  // 0 or 1, for COLMAP's options.
  std::string use_gpu() const { return uses_gpu_ ? "1" : "0"; }
  std::string threads() const { return std::to_string(threads_); }
  const std::string& log() const { return log_; }

 private:
  // Everything that the command prints for -h.
  std::string HelpOf(const std::vector<std::string>& words) const;

  std::string program_, log_, work_;
  bool uses_gpu_ = false;
  int threads_;
};

}  // namespace vesta::app
