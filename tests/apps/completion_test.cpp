// What shells and man make of the scripts and the manual that the program prints. Each is skipped where it is missing.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "apps/flags.h"
#include "problems/gaussian_splatting/train/options.h"
#include "tests/apps/run_program.h"

namespace vesta::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Both outputs of a command of the shell.
std::string Shell(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return "no shell";
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  pclose(pipe);
  return text;
}

bool Has(const char* program) { return !Shell(fmt::format("command -v {}", program)).empty(); }

class Completion : public testing::Test {
 protected:
  // The file that holds the script.
  std::string Write(const std::string& kind) const {
    const ProgramOutput output = RunProgram({"help", kind});
    EXPECT_EQ(output.status, 0) << output.err;
    std::ofstream(file_, std::ios::binary) << output.out;
    return file_;
  }
  // What bash offers behind the words, of which it makes more at each "=".
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
  EXPECT_EQ(InBash("vesta train --set = lm.jacobian = rec"), "recompute\n");
  EXPECT_EQ(InBash("vesta eval a b --align = pose+"), "pose+colour\n");
  EXPECT_EQ(InBash("vesta refine a b --sh_deg"), "\n") << "of other commands alone";
}

TEST_F(Completion, OfZsh) {
  if (!Has("zsh")) GTEST_SKIP() << "no zsh";
  EXPECT_THAT(Shell("zsh -n " + Write("--completion=zsh")), IsEmpty());
}

TEST_F(Completion, OfFish) {
  if (!Has("fish")) GTEST_SKIP() << "no fish";
  EXPECT_THAT(Shell("fish -n " + Write("--completion=fish")), IsEmpty());
  EXPECT_THAT(Shell(fmt::format("fish -c 'source {}; complete -C \"vesta train --preset=f\"'", file_)),
              testing::StartsWith("--preset=fast"));
}

TEST_F(Completion, NamesEveryFlagInEveryShell) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const std::string script = ReadFile(Write(fmt::format("--completion={}", shell)));
    for (const char* flag : {"out", "preset", "threads", "noreport", "max_loss", "align", "loss_scale", "log_lm"}) {
      EXPECT_THAT(script, HasSubstr(flag)) << shell;
    }
    for (const auto& field : gs::TrainFields()) EXPECT_THAT(script, HasSubstr(field.name + "=")) << shell;
  }
  EXPECT_EQ(RunProgram({"help", "--completion=tcsh"}).status, 2);
}

TEST_F(Completion, ManualIsSound) {
  const std::string file = Write("--man"), text = ReadFile(file);
  EXPECT_THAT(text, HasSubstr("\n.SS vesta train SCENE \\-\\-out=DIR\n"));
  for (const auto& field : gs::TrainFields()) EXPECT_THAT(text, HasSubstr("\n\\fB" + field.name + "=")) << field.name;
  if (!Has("man")) GTEST_SKIP() << "no man";
  EXPECT_THAT(Shell(fmt::format("man --warnings -l {} >/dev/null", file)), IsEmpty());
}

}  // namespace
}  // namespace vesta::test
