#include "apps/usage/man_page.h"

#include <fmt/format.h>

#include <string_view>

#include "apps/cli/version.h"
#include "apps/usage/flag_list.h"

namespace vesta::app {
namespace {

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
