// SPDX-License-Identifier: Apache-2.0
// Shells and man accept the completion scripts and the manual. Missing shells are skipped.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include "apps/cli/flags.h"
#include "splatting/train/settings/train_options.h"
#include "tests/apps/run_program.h"

namespace vesta::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Stdout and stderr of a shell command.
std::string Shell(const std::string& command) { return RunShell(command + " 2>&1").out; }

bool Has(const char* program) { return !Shell(fmt::format("command -v {}", program)).empty(); }

class Completion : public testing::Test {
 protected:
  // Returns the script's path.
  std::string Write(const std::string& kind) const {
    const ProgramOutput output = RunProgram({"help", kind});
    EXPECT_EQ(output.status, 0) << output.err;
    std::ofstream(file_, std::ios::binary) << output.out;
    return file_;
  }
  // The completions of bash after these words. Bash splits words at "=".
  std::string InBash(const std::string& words) const {
    return Shell(
        fmt::format("bash -c 'source {} && COMP_WORDS=({}) && COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)) && "
                    "{{ _vesta 2>/dev/null; echo ${{COMPREPLY[*]}}; }}'",
                    file_, words));
  }

  TempFolder folder_;
  std::string file_ = folder_ / "script";
};

TEST_F(Completion, OfBash) {
  if (!Has("bash")) GTEST_SKIP() << "no bash";
  EXPECT_THAT(Shell("bash -n " + Write("--completion=bash")), IsEmpty());
  EXPECT_EQ(InBash("vesta tr"), "train\n");
  EXPECT_EQ(InBash("vesta train --pres"), "--preset=\n");
  EXPECT_EQ(InBash("vesta train --preset = f"), "fast\n");
  EXPECT_EQ(InBash("vesta train --preset ="), "fast balanced best paper paper_code\n");
  EXPECT_EQ(InBash("vesta train --set = lm.jac"), "lm.jacobian=\n");
  EXPECT_EQ(InBash("vesta train --set lm.jac"), "lm.jacobian=\n");
  EXPECT_EQ(InBash("vesta train --set = lm.jacobian = cached"), "cached_views\n");
  EXPECT_EQ(InBash("vesta eval a b --align = pose+"), "pose+colour\n");
  EXPECT_EQ(InBash("vesta refine a b --sh_deg"), "\n") << "a flag of other commands only";
  EXPECT_EQ(InBash("vesta train --vie"), "--view --view=\n") << "with or without a port";
  EXPECT_EQ(InBash("vesta help --completion = z"), "zsh\n");
  const std::string begun = file_.substr(0, file_.size() - 2);
  EXPECT_EQ(InBash("vesta render a b --path = orb"), "orbit\n") << "one of the keywords";
  for (const char* flag : {"render a b --path", "render a b --film", "train --config"}) {
    EXPECT_EQ(InBash(fmt::format("vesta {} = {}", flag, begun)), file_ + "\n") << flag << ": or a file";
  }
}

TEST_F(Completion, OfZsh) {
  if (!Has("zsh")) GTEST_SKIP() << "no zsh";
  EXPECT_THAT(Shell("zsh -n " + Write("--completion=zsh")), IsEmpty());
}

TEST_F(Completion, OfZshHasArgumentsThatNeedNotBe) {
  const std::string script = ReadBytes(Write("--completion=zsh"));
  EXPECT_THAT(script, HasSubstr("'2::SCENE:_files -/' ;;")) << "of the command view";
  EXPECT_THAT(script, HasSubstr("{compadd orbit spiral photographs; _files}"));
  EXPECT_THAT(script, HasSubstr("'--view=-["));
}

TEST_F(Completion, OfFish) {
  if (!Has("fish")) GTEST_SKIP() << "no fish";
  EXPECT_THAT(Shell("fish -n " + Write("--completion=fish")), IsEmpty());
  EXPECT_THAT(Shell(fmt::format("fish -c 'source {}; complete -C \"vesta train --preset=f\"'", file_)),
              testing::StartsWith("--preset=fast"));
}

TEST_F(Completion, NamesEveryFlagInEveryShell) {
  // The help prints one a line.
  const std::regex flag_of_help("\n  --([a-z_]+)"), command_of_help("\n  vesta ([a-z_]+)");
  const auto all_of = [](const std::string& text, const std::regex& what) {
    std::vector<std::string> found;
    for (std::sregex_iterator i(text.begin(), text.end(), what), end; i != end; ++i) found.push_back((*i)[1]);
    return found;
  };
  std::vector<std::string> flags;
  for (const std::string& command : all_of(RunProgram({"help"}).out, command_of_help)) {
    if (command == "help") continue;
    const std::string help = RunProgram({"help", command, "--all"}).out;
    for (const std::string& flag : all_of(help, flag_of_help)) flags.push_back(flag);
  }
  EXPECT_GT(flags.size(), 100U);
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const std::string script = ReadBytes(Write(fmt::format("--completion={}", shell)));
    const char* before = shell == std::string("fish") ? "-l " : "--";
    for (const std::string& flag : flags) EXPECT_THAT(script, HasSubstr(before + flag)) << shell;
    for (const char* flag : {"all", "man", "completion"}) EXPECT_THAT(script, HasSubstr(before + std::string(flag)));
    for (const auto& field : gs::TrainFields()) EXPECT_THAT(script, HasSubstr(field.name + "=")) << shell;
  }
  EXPECT_EQ(RunProgram({"help", "--completion=tcsh"}).status, 2);
}

TEST_F(Completion, ManualIsSound) {
  const std::string file = Write("--man"), text = ReadBytes(file);
  EXPECT_THAT(text, HasSubstr("\n.SS vesta train SCENE \\-\\-out=DIR\n"));
  EXPECT_THAT(text, HasSubstr("\n.PP\n\\fIQuality and time\\fR\n.TP\n\\fB\\-\\-preset="));
  for (const auto& field : gs::TrainFields()) EXPECT_THAT(text, HasSubstr("\n\\fB" + field.name + "=")) << field.name;
  if (!Has("man")) GTEST_SKIP() << "no man";
  EXPECT_THAT(Shell(fmt::format("man --warnings -l {} >/dev/null", file)), IsEmpty());
}

}  // namespace
}  // namespace vesta::test
