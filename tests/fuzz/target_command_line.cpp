// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/cli/print.h"
#include "apps/training/checkpointing.h"
#include "apps/usage/parse_command_line.h"
#include "tests/fuzz/options_promise.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

std::vector<std::string> Lines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(std::string(text.substr(0, end)).c_str());  // up to a zero byte, which argv cannot contain
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace

void FuzzCommandLine(std::string_view bytes) {
  try {
    const app::CommandLine line = app::ParseCommandLine(Lines(bytes));
    if (!line.command) return;
    if (line.flags.resume.empty()) {
      const std::size_t given = line.arguments.size(), least = line.command->arguments.size();
      const bool may_be_more = line.command->repeats || (line.command->optional && given == least + 1);
      Promise(given == least || (given > least && may_be_more), "a wrong number of arguments");
    }
    app::ParseInterval("checkpoint_every", line.flags.checkpoint_every);
    const std::string& preset = line.flags.preset;
    gs::TrainOptions options = gs::PresetOptions(preset.empty() ? app::kDefaultPreset : preset);
    for (const app::GivenOption& given : line.options) {
      Promise(given.field->Set(given.value, options), given.field->name + " refuses a value that it accepted before");
    }
    PromiseOptions(options);
  } catch (const app::UsageError& error) {
    PromiseOneLine(app::OneLine(error.what()));  // as main prints it; it may quote the input
  }
}

}  // namespace vesta::fuzz
