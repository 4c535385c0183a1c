#include "apps/help.h"

#include <fmt/format.h>

#include "apps/command_line.h"
#include "apps/train_settings.h"

namespace vesta::app {
namespace {

constexpr std::size_t kWidth = 38;  // column of the descriptions

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
      "SPLAT is a .ply in the INRIA layout, a .compressed.ply (SuperSplat) or a .spz (Niantic).\n"
      "FILE is a bundle adjustment in the text form of \"Bundle adjustment in the large\".\n";
  return text;
}

// "  NAME=VALUE   what for [what it is without being given]". A name too long has a line of its own.
std::string Line(const std::string& name, const schema::FieldInfo& field, const std::string& help,
                 const std::string& value) {
  const bool is_flag = name.starts_with("--") && field.kind == schema::Kind::kSwitch;
  const std::string head = is_flag ? name : name + "=" + field.Placeholder();
  const std::string brackets = is_flag || value.empty() ? "" : fmt::format(" [{}]", value);
  if (head.size() > kWidth) return fmt::format("  {}\n  {:<{}} {}{}\n", head, "", kWidth, help, brackets);
  return fmt::format("  {:<{}} {}{}\n", head, kWidth, help, brackets);
}

std::string OwnFlags(const std::vector<FlagRow>& rows, const CommandInfo& command, bool all) {
  std::string text;
  for (const FlagRow& row : rows) {
    if (!(row.commands & command.command) || ((row.rare_for & command.command) && !all)) continue;
    const std::string value = row.field.name == "preset" ? kDefaultPreset : row.field.Text(Flags());
    text += Line("--" + row.field.name, row.field, row.field.help, value);
  }
  return text;
}

std::string OptionFlags(const CommandInfo& command) {
  const gs::TrainOptions defaults = PresetOf(command, kDefaultPreset);
  std::string text;
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    if (!field.flag || !TakesOption(command, field)) continue;
    text += Line(fmt::format("--{}", field.flag), field, field.help, field.Text(defaults));
  }
  return text;
}

// Room by room, with the range of each.
std::string AllOptions(const CommandInfo& command) {
  const gs::TrainOptions defaults = PresetOf(command, kDefaultPreset);
  std::string text = "\nAll options, to be set by --set KEY=VALUE; some have a flag too:\n", last_room;
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    if (!TakesOption(command, field)) continue;
    const std::string room = field.name.substr(0, field.name.find('.'));
    if (room != last_room) text += "\n";
    last_room = room;
    const bool is_number = field.kind == schema::Kind::kWhole || field.kind == schema::Kind::kNumber;
    text += Line(field.name, field,
                 fmt::format("{}{}{}", field.help, is_number ? "; " + field.Allowed() : "",
                             field.flag ? fmt::format(" (--{})", field.flag) : ""),
                 field.Text(defaults));
  }
  return text;
}

std::string HelpOf(const CommandInfo& command, bool all) {
  std::string text = fmt::format("{} [flags]: {}\n\n", UsageForm(command), command.summary);
  text += OwnFlags(ProgramFlags().before_options, command, all);
  text += OptionFlags(command);
  text += OwnFlags(ProgramFlags().after_options, command, all);
  const bool trains = command.command & (kTrain | kRefine | kPrune);
  if (trains || command.command == kConfig) {
    if (all) {
      text += AllOptions(command);
    } else {
      text += fmt::format("\n`vesta help {} --all` lists the keys of --set.\n", command.name);
    }
    text += "\nWhat is not given is the preset's, in brackets that of balanced.\n";
  }
  if (trains) {
    text +=
        "Writes DIR/point_cloud.ply and DIR/metrics.json. Ctrl-C ends training after the current iteration and writes\n"
        "what there is (exit status 130).\n";
  }
  if (command.command & (kRefine | kPrune)) {
    text += fmt::format(
        "The SH degree{} of SPLAT stay{}. Give --background where it was trained over another\n"
        "colour than black and does not say so.\n",
        command.command == kRefine ? " and the number of Gaussians" : "", command.command == kRefine ? "" : "s");
  }
  return text;
}

}  // namespace

std::string HelpText(const std::vector<std::string>& topic) {
  if (topic.empty() || topic[0] == "help") return Overview();
  if (topic[0] == "version") return "vesta " VESTA_VERSION "\n";
  const CommandInfo* command = FindCommand(topic[0]);
  if (!command) throw UsageError(fmt::format("{}: no such command; `vesta help` lists them", topic[0]));
  if (topic.size() > 1 && topic[1] != "--all") {
    throw UsageError(fmt::format("{}: too much; the form is `vesta help COMMAND [--all]`", topic[1]));
  }
  return HelpOf(*command, topic.size() > 1);
}

}  // namespace vesta::app
