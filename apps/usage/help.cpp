// SPDX-License-Identifier: Apache-2.0
#include "apps/usage/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "apps/cli/flags.h"
#include "apps/cli/version.h"
#include "apps/usage/parse_command_line.h"

namespace vesta::app {
namespace {

constexpr std::size_t kWidth = 80, kColumn = 28;  // of a line; start of descriptions

// Appends the words of `text` to `line` and breaks lines at kWidth; further lines have `indent` spaces.
std::string Wrapped(std::string line, std::size_t indent, const std::string& text) {
  std::string lines;
  std::istringstream words(text);
  bool is_first = true;  // on its line
  for (std::string word; words >> word; is_first = false) {
    if (!is_first && line.size() + 1 + word.size() > kWidth) {
      lines += line + "\n";
      line = std::string(indent, ' ');
      is_first = true;
    }
    line += (is_first ? "" : " ") + word;
  }
  return lines + line + "\n";
}

// "  HEAD    description". A head too long for its column has its own line.
std::string Row(const std::string& head, const std::string& description, std::size_t column = kColumn) {
  std::string line = "  " + head, before;
  if (line.size() + 2 > column) before = std::exchange(line, "") + "\n";
  line.resize(column, ' ');
  return before + Wrapped(line, column, description);
}

std::string Overview() {
  constexpr std::size_t kCommandColumn = 40;
  std::string text = "vesta: train, refine and measure 3D Gaussian splats; matrix-free least squares\n\n";
  for (const CommandInfo& command : Commands()) text += Row(UsageForm(command), command.summary, kCommandColumn);
  text += Row("vesta help COMMAND", "list the flags of a command", kCommandColumn);
  text += Row("vesta help --completion=SHELL", "print completions for bash, zsh or fish", kCommandColumn);
  text += Row("vesta help --man", "print the manual page", kCommandColumn);
  for (const char* paragraph :
       {"PHOTOS is a folder of photographs, or a film.",
        "SCENE is a folder with photographs and cameras: a COLMAP model (images/ and sparse/0/) or a NeRF scene "
        "(transforms.json). Every 8th photograph by name, starting with the first, is a test view.",
        "SPLAT is a .ply in the INRIA layout, a .compressed.ply or .sog (SuperSplat), a .spz (Niantic), a .splat "
        "(antimatter15) or a .ksplat (GaussianSplats3D). view also accepts a checkpoint (DIR/checkpoint.vesta).",
        "FILE is a bundle adjustment problem in the text format of \"Bundle Adjustment in the Large\" (BAL)."}) {
    text += "\n" + Wrapped("", 0, paragraph);
  }
  return text;
}

std::string WithDefault(const std::string& help, const std::string& value) {
  return value.empty() ? help : fmt::format("{} [{}]", help, value);
}

std::string Head(const ListedFlag& flag) {
  return flag.Written() + (flag.is_switch() ? "" : fmt::format("={}", flag.field->Placeholder()));
}

std::string Description(const ListedFlag& flag) {
  return WithDefault(flag.field->help, flag.is_switch() ? "" : flag.value);
}

std::string FlagRows(const CommandInfo& command, bool all) {
  std::string text;
  std::optional<FlagGroup> group;
  for (const ListedFlag& flag : FlagsOf(command)) {
    if (flag.only_in_all && !all) continue;
    if (group != flag.group) text += fmt::format("\n{}:\n", Heading(flag.group));
    group = flag.group;
    text += Row(Head(flag), Description(flag));
  }
  return text;
}

// Title of the options "PART.".
std::string TitleOf(const std::string& part) {
  static const std::map<std::string, std::string> titles = {
      {"adam", "Adam stage"},       {"cameras", "Camera refinement"},
      {"density", "Densification"}, {"lm", "Levenberg-Marquardt (LM) stage"},
      {"pruning", "Pruning"},       {"train", "Training"},
      {"memory", "Memory"},         {"lr", "Learning rates of Adam"}};
  const auto found = titles.find(part);
  return found == titles.end() ? part : found->second;
}

// Every option with its range, grouped by part of the training.
std::string OptionRows(const CommandInfo& command) {
  std::string text = "\nAll options, for --set KEY=VALUE (some also have a flag):\n", last_part;
  for (const ListedFlag& option : OptionsOf(command)) {
    const schema::FieldInfo& field = *option.field;
    const std::string part = field.name.substr(0, field.name.find('.'));
    if (part != last_part) text += fmt::format("\n{}:\n", TitleOf(part));
    last_part = part;
    const bool is_number = field.kind == schema::Kind::kWhole || field.kind == schema::Kind::kNumber;
    const std::string help = fmt::format("{}{}{}", field.help, is_number ? "; " + field.Allowed() : "",
                                         field.flag ? fmt::format(" (--{})", field.flag) : "");
    text += Row(field.name + "=" + field.Placeholder(), WithDefault(help, option.value));
  }
  return text;
}

std::string HelpOf(const CommandInfo& command, bool all) {
  std::string text = fmt::format("{} [flags]\n", UsageForm(command)) + Wrapped("", 0, command.summary);
  text += FlagRows(command, all);
  const bool trains = command.command & (kTrain | kRefine | kPrune), has_keys = trains || command.command == kConfig;
  if (all && has_keys) text += OptionRows(command);
  std::string notes;
  if (!all && (has_keys || std::ranges::any_of(FlagsOf(command), &ListedFlag::only_in_all))) {
    notes += fmt::format("`vesta help {} --all` lists more flags{}. ", command.name,
                         has_keys ? ", and the keys for --set" : "");
  }
  notes += has_keys ? "Defaults (of --preset=balanced) are in brackets." : "Defaults are in brackets.";
  text += "\n" + Wrapped("", 0, notes);
  notes.clear();
  if (command.command == kReconstruct) {
    notes +=
        "Runs COLMAP (Debian package colmap), and ffmpeg for films. Writes SCENE/images and SCENE/sparse/0, the input "
        "of "
        "vesta train. SCENE/reconstruction has the log of all commands, and the state to continue from. ";
  }
  if (trains) {
    notes +=
        "Writes DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html. Ctrl-C ends the training after the current "
        "iteration and writes the result so far (exit status 130). ";
  }
  if (command.command & (kTrain | kRefine)) {
    notes += "If --refine_cameras moves cameras, they are written to DIR/cameras as a COLMAP model. ";
  }
  if (command.command & (kRefine | kPrune)) {
    notes += fmt::format(
        "The result has the SH degree{} of SPLAT. If SPLAT was trained on a background that is not black and its file "
        "does not record it, give --background.",
        command.command == kRefine ? " and the number of Gaussians" : "");
  }
  return notes.empty() ? text : text + "\n" + Wrapped("", 0, notes);
}

// Escapes text for roff: hyphens stay copyable, and no line begins with a request.
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

std::string ManItem(const std::string& head, const std::string& description) {
  return fmt::format(".TP\n\\fB{}\\fR\n{}\n", Roff(head), Roff(description));
}

std::string ManHeading(const std::string& heading) { return fmt::format(".PP\n\\fI{}\\fR\n", Roff(heading)); }

std::string ManSection(const CommandInfo& command) {
  std::string text = fmt::format(".SS {}\n{}.\n", Roff(UsageForm(command)), Roff(command.summary));
  std::optional<FlagGroup> group;
  for (const ListedFlag& flag : FlagsOf(command)) {
    if (group != flag.group) text += ManHeading(Heading(flag.group));
    group = flag.group;
    text += ManItem(Head(flag), Description(flag));
  }
  return text;
}

std::string ManOptions() {
  std::string text =
      ".SH OPTIONS OF TRAINING\nFor \\fB\\-\\-set\\fR. \\fBrefine\\fR and \\fBprune\\fR accept the options that an "
      "existing splat leaves open. The defaults of the preset balanced are in brackets.\n";
  std::string last_part;
  for (const ListedFlag& option : OptionsOf(*FindCommand("train"))) {
    const std::string part = option.name.substr(0, option.name.find('.'));
    if (part != last_part) text += ManHeading(TitleOf(part));
    last_part = part;
    text += ManItem(fmt::format("{}={}", option.name, option.field->Placeholder()),
                    WithDefault(option.field->help, option.value));
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
    throw UsageError(fmt::format("{}: unexpected argument; the form is `vesta help COMMAND [--all]`", topic[1]));
  }
  return HelpOf(*command, topic.size() > 1);
}

std::string ManPage() {
  std::string text = fmt::format(".TH VESTA 1 \"\" \"vesta {}\" \"User Commands\"\n", VersionNumber());
  text +=
      ".SH NAME\nvesta \\- train, refine and measure 3D Gaussian splats; matrix\\-free least squares\n"
      ".SH SYNOPSIS\n";
  for (const CommandInfo& command : Commands()) {
    text += fmt::format(".B {}\n[\\fIflags\\fR]\n.br\n", Roff(UsageForm(command)));
  }
  text += ".B vesta help\n[\\fICOMMAND\\fR [\\fB\\-\\-all\\fR]]\n";
  text +=
      ".SH DESCRIPTION\nPHOTOS is a folder of photographs, or a film. SCENE is a folder with photographs and cameras: "
      "a COLMAP model (images/ and sparse/0/) or a "
      "NeRF "
      "scene (transforms.json). Every 8th photograph by name is a test view. SPLAT is a .ply, .compressed.ply, .spz, "
      ".splat, .ksplat or .sog.\n"
      ".SH COMMANDS\n";
  for (const CommandInfo& command : Commands()) text += ManSection(command);
  text += ManOptions();
  text +=
      ".SH FILES\nA training run writes DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html.\n"
      ".SH ENVIRONMENT\n.TP\n.B VESTA_SIMD\nsse2, avx2 or avx512: the instruction set to use; by default the best one "
      "of this CPU.\n"
      ".SH EXIT STATUS\n0: success. 1: an input could not be used or a result could not be written. 2: error in the "
      "command line. 130: interrupted; the result so far is written.\n";
  return text;
}

}  // namespace vesta::app
