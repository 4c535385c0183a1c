// SPDX-License-Identifier: Apache-2.0
#include "apps/usage/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "apps/cli/flags.h"
#include "apps/cli/version.h"
#include "apps/usage/parse_command_line.h"

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
  text += fmt::format("  {:<36}{}\n", "vesta help --completion=SHELL",
                      "completion of the command line, for bash, zsh or fish");
  text += fmt::format("  {:<36}{}\n", "vesta help --man", "the manual, for man");
  text +=
      "\nSCENE is a folder: a COLMAP model (images/ and sparse/0/) or a NeRF one (transforms.json).\n"
      "Every 8th image by name, from the first on, is kept for testing.\n"
      "SPLAT is a .ply in the INRIA layout, a .compressed.ply (SuperSplat) or a .spz (Niantic);\n"
      "view takes a checkpoint of a training (DIR/checkpoint.vesta) too.\n"
      "FILE is a bundle adjustment in the text form of \"Bundle adjustment in the large\".\n"
      "With --quiet, what writes files prints nothing but errors.\n";
  return text;
}

// "  NAME=VALUE   what for [what it is without being given]". A name too long has a line of its own.
std::string Line(const std::string& head, const std::string& help, const std::string& value) {
  const std::string brackets = value.empty() ? "" : fmt::format(" [{}]", value);
  if (head.size() > kWidth) return fmt::format("  {}\n  {:<{}} {}{}\n", head, "", kWidth, help, brackets);
  return fmt::format("  {:<{}} {}{}\n", head, kWidth, help, brackets);
}

std::string FlagLines(const CommandInfo& command, bool all) {
  std::string text;
  for (const ListedFlag& flag : FlagsOf(command)) {
    if (flag.only_in_all && !all) continue;
    text += flag.is_switch() ? Line(flag.Written(), flag.field->help, "")
                             : Line(flag.Written() + "=" + flag.field->Placeholder(), flag.field->help, flag.value);
  }
  return text;
}

// Room by room, with the range of each.
std::string AllOptions(const CommandInfo& command) {
  std::string text = "\nAll options, to be set by --set KEY=VALUE; some have a flag too:\n", last_room;
  for (const ListedFlag& option : OptionsOf(command)) {
    const schema::FieldInfo& field = *option.field;
    const std::string room = field.name.substr(0, field.name.find('.'));
    if (room != last_room) text += "\n";
    last_room = room;
    const bool is_number = field.kind == schema::Kind::kWhole || field.kind == schema::Kind::kNumber;
    text += Line(field.name + "=" + field.Placeholder(),
                 fmt::format("{}{}{}", field.help, is_number ? "; " + field.Allowed() : "",
                             field.flag ? fmt::format(" (--{})", field.flag) : ""),
                 option.value);
  }
  return text;
}

std::string HelpOf(const CommandInfo& command, bool all) {
  std::string text = fmt::format("{} [flags]: {}\n\n", UsageForm(command), command.summary);
  text += FlagLines(command, all);
  const bool trains = command.command & (kTrain | kRefine | kPrune), has_keys = trains || command.command == kConfig;
  if (all && has_keys) text += AllOptions(command);
  if (!all && (has_keys || std::ranges::any_of(FlagsOf(command), &ListedFlag::only_in_all))) {
    text += fmt::format("\n`vesta help {} --all` has more flags{}.\n", command.name,
                        has_keys ? ", and the keys of --set" : "");
  }
  if (has_keys) text += "\nWhat is not given is the preset's, in brackets that of balanced.\n";
  if (trains) {
    text +=
        "Writes DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html (--noreport: without the last). Ctrl-C ends\n"
        "training after the current iteration and writes what there is (exit status 130).\n";
  }
  if (command.command & (kTrain | kRefine)) {
    text += "Where --refine_cameras has moved cameras they are in DIR/cameras, as a COLMAP model.\n";
  }
  if (command.command == kTrain) text += "--view shows it in a browser while it runs.\n";
  if (command.command & (kRefine | kPrune)) {
    text += fmt::format(
        "The SH degree{} of SPLAT stay{}. Give --background where it was trained over another\n"
        "colour than black and does not say so.\n",
        command.command == kRefine ? " and the number of Gaussians" : "", command.command == kRefine ? "" : "s");
  }
  return text;
}

// Text within a line: a hyphen is one that can be copied, and no line becomes a request.
std::string Roff(std::string_view text) {
  std::string escaped = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else if (c == '~') {
      escaped += "\\(ti";
    } else if (c == '^') {
      escaped += "\\(ha";
    } else if (c == '`') {
      escaped += "\\(ga";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string Item(const std::string& head, const std::string& what) {
  return fmt::format(".TP\n\\fB{}\\fR\n{}\n", Roff(head), Roff(what));
}

std::string WithValue(const ListedFlag& flag, const std::string& name) {
  return flag.is_switch() ? name : fmt::format("{}={}", name, flag.field->Placeholder());
}

std::string Described(const ListedFlag& flag) {
  const bool says_value = !flag.is_switch() && !flag.value.empty();
  return says_value ? fmt::format("{} [{}]", flag.field->help, flag.value) : flag.field->help;
}

std::string Section(const CommandInfo& command) {
  std::string text = fmt::format(".SS {}\n{}.\n", Roff(UsageForm(command)), Roff(command.summary));
  for (const ListedFlag& flag : FlagsOf(command)) text += Item(WithValue(flag, flag.Written()), Described(flag));
  return text;
}

std::string OptionsOfTraining() {
  std::string text =
      ".SH OPTIONS OF TRAINING\nFor \\fB\\-\\-set\\fR; \\fBrefine\\fR and \\fBprune\\fR take those that a given splat "
      "leaves open. In brackets: what it is where nothing is given.\n";
  for (const ListedFlag& option : OptionsOf(*FindCommand("train"))) {
    text += Item(fmt::format("{}={}", option.name, option.field->Placeholder()), Described(option));
  }
  return text;
}

}  // namespace

std::string HelpText(const std::vector<std::string>& topic) {
  if (topic.empty() || topic[0] == "help") return Overview();
  if (topic[0] == "version") return VersionText();
  if (topic[0] == "--man") return ManPage();
  if (topic[0].starts_with("--completion=")) return CompletionScript(topic[0].substr(topic[0].find('=') + 1));
  const CommandInfo* command = FindCommand(topic[0]);
  if (!command) RefuseCommand(topic[0]);
  if (topic.size() > 1 && topic[1] != "--all") {
    throw UsageError(fmt::format("{}: too much; the form is `vesta help COMMAND [--all]`", topic[1]));
  }
  return HelpOf(*command, topic.size() > 1);
}

std::string ManPage() {
  std::string text = fmt::format(".TH VESTA 1 \"\" \"vesta {}\" \"User Commands\"\n", VersionNumber());
  text +=
      ".SH NAME\nvesta \\- train, refine and measure 3D Gaussian splats; least squares without a matrix\n"
      ".SH SYNOPSIS\n";
  for (const CommandInfo& command : Commands()) {
    text += fmt::format(".B {}\n[\\fIflags\\fR]\n.br\n", Roff(UsageForm(command)));
  }
  text += ".B vesta help\n[\\fICOMMAND\\fR [\\fB\\-\\-all\\fR]]\n";
  text +=
      ".SH DESCRIPTION\nSCENE is a folder: a COLMAP model (images/ and sparse/0/) or a NeRF one (transforms.json). "
      "Every "
      "8th image by name is kept for testing. SPLAT is a .ply, a .compressed.ply or a .spz.\n"
      ".SH COMMANDS\n";
  for (const CommandInfo& command : Commands()) text += Section(command);
  text += OptionsOfTraining();
  text +=
      ".SH FILES\nA training writes DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html.\n"
      ".SH ENVIRONMENT\n.TP\n.B VESTA_SIMD\nsse2, avx2 or avx512: the instruction set to use; the best one otherwise.\n"
      ".SH EXIT STATUS\n0: done. 1: something could not be used or written. 2: the command line is not understood. "
      "130: "
      "interrupted; results are written.\n";
  return text;
}

}  // namespace vesta::app
