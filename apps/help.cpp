#include "apps/help.h"

#include <fmt/format.h>
#include <gflags/gflags.h>

#include "apps/flag_values.h"
#include "apps/flags.h"
#include "apps/train_flags.h"

namespace vesta::app {
namespace {

constexpr std::size_t kFlagWidth = 38;  // column of the descriptions

std::string Overview() {
  std::string text =
      "vesta: least squares by matrix-free Levenberg-Marquardt: 3D Gaussian splats, bundle adjustment\n\n";
  for (const CommandInfo& command : Commands()) {
    text += fmt::format("  {:<36}{}\n", UsageForm(command), command.summary);
  }
  text += fmt::format("  {:<36}{}\n", "vesta help COMMAND", "the flags of a command");
  text +=
      "\nSCENE is a folder: a COLMAP model (images/ and sparse/0/) or a NeRF one (transforms.json).\n"
      "Every 8th image by name, from the first on, is kept for testing.\n"
      "FILE is a bundle adjustment in the text form of \"Bundle adjustment in the large\".\n";
  return text;
}

// What the flag is without being given.
std::string PresetText(const CommandInfo& command, const FlagRule& rule) {
  if (std::holds_alternative<Switch>(rule.values)) return "";
  if (command.command == kTrain) return OptionText(gs::PresetOptions("balanced"), rule.name);
  if (command.command == kRefine) return OptionText(gs::RefinePresetOptions("balanced"), rule.name);
  return "";
}

std::string Flags(const CommandInfo& command) {
  std::string text = fmt::format("{} [flags]: {}\n\n", UsageForm(command), command.summary);
  for (const FlagRule& rule : FlagRules()) {
    if (!(rule.commands & command.command)) continue;
    const std::string value = std::string("out") == rule.name ? command.output : ValuePlaceholder(rule);
    const std::string flag = fmt::format("--{}{}{}", rule.name, value.empty() ? "" : "=", value);
    if (flag.size() > kFlagWidth) text += fmt::format("  {}\n", flag);
    const std::string preset = PresetText(command, rule);
    text += fmt::format("  {:<{}} {}{}\n", flag.size() > kFlagWidth ? "" : flag, kFlagWidth,
                        gflags::GetCommandLineFlagInfoOrDie(rule.name).description,
                        preset.empty() ? "" : fmt::format(" [{}]", preset));
  }
  if (command.command & (kTrain | kRefine)) {
    text +=
        "\nWrites DIR/point_cloud.ply and DIR/metrics.json. Options not given are the preset's, in brackets those of\n"
        "balanced. Ctrl-C ends training after the current iteration and writes what there is (exit status 130).\n";
  }
  if (command.command == kRefine) {
    text +=
        "PLY is in the INRIA layout; its SH degree and its number of Gaussians stay. Give --background where it was\n"
        "trained over another colour than black and does not say so.\n";
  }
  return text;
}

}  // namespace

std::string HelpText(const std::vector<std::string>& topic) {
  if (topic.empty() || topic[0] == "help") return Overview();
  if (topic[0] == "version") return "vesta " VESTA_VERSION "\n";
  const CommandInfo* command = FindCommand(topic[0]);
  if (!command) throw UsageError(fmt::format("{}: no such command; `vesta help` lists them", topic[0]));
  return Flags(*command);
}

}  // namespace vesta::app
