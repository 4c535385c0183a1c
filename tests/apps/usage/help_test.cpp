// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>

#include "splatting/train/settings/train_options.h"
#include "tests/apps/run_program.h"

namespace vesta::test {
namespace {

using testing::HasSubstr;
using testing::Not;

// Every line break and the spaces around it as one space.
std::string Unwrapped(const std::string& text) { return std::regex_replace(text, std::regex("[ \n]+"), " "); }

std::size_t LongestLine(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, line.size());
  return longest;
}

// The output of a help command, after checks for every one.
std::string Help(const std::vector<std::string>& arguments) {
  const ProgramOutput output = RunProgram(arguments);
  EXPECT_EQ(output.status, 0);
  EXPECT_EQ(output.err, "");
  EXPECT_LE(CountLines(output.out), 72);
  EXPECT_LE(LongestLine(output.out), 80U);
  EXPECT_THAT(output.out, Not(HasSubstr("alsologtostderr")));  // no flags of the libraries
  return output.out;
}

TEST(Help, OverviewNamesTheCommands) {
  const std::string text = Help({"help"});
  for (const char* command :
       {"vesta reconstruct", "vesta train", "vesta refine", "vesta prune", "vesta eval", "vesta render",
        "vesta convert", "vesta report", "vesta doctor", "vesta config", "vesta bundle_adjust", "vesta help"}) {
    EXPECT_THAT(text, HasSubstr(command));
  }
  EXPECT_EQ(Help({"--help"}), text);
  EXPECT_EQ(Help({"-h"}), text);
}

TEST(Help, SaysWhichVersion) {
  EXPECT_THAT(
      Help({"--version"}),
      testing::MatchesRegex(
          "vesta [0-9.]+ \\(commit [0-9a-z-]+\\)\ninstruction sets: sse2.*; this CPU has sse2.*; used: [a-z0-9]+\n"));
}

// Defaults are in brackets; refine has its own.
TEST(Help, SaysWhatFlagsAreWithoutBeingGiven) {
  const auto help = [](const char* command) { return Unwrapped(RunProgram({"help", command, "--all"}).out); };
  EXPECT_THAT(help("train"), HasSubstr("less than this fraction; 0: never; from 0 to 1 [0.006]"));
  EXPECT_THAT(help("refine"), HasSubstr("less than this fraction; 0: never; from 0 to 1 [0.001]"));
}

// Groups have a fixed order, and each has a flag that belongs there.
TEST(Help, GroupsFlagsUnderHeadings) {
  const std::string train = Help({"help", "train"});
  std::size_t at = 0;
  for (const char* next :
       {"\nInput:\n", "\n  --downscale=", "\nQuality and time:\n", "\n  --preset=", "\n  --iterations=", "\nOutput:\n",
        "\n  --out=DIR", "\nResources:\n", "\n  --memory_budget=", "\nOther:\n", "\n  --seed="}) {
    const std::size_t found = train.find(next, at);
    ASSERT_NE(found, std::string::npos) << next;
    at = found;
  }
  EXPECT_THAT(train, Not(HasSubstr("\nBrowser page:\n"))) << "its flags are listed only with --all";
  const std::string all = RunProgram({"help", "train", "--all"}).out;
  EXPECT_THAT(all, HasSubstr("\nBrowser page:\n  --view=PORT"));
  EXPECT_THAT(all, HasSubstr("\nPruning:\n  pruning.unseen="));
}

// Rows wrap, with indented continuation lines.
TEST(Help, FitsEightyColumns) {
  for (const std::string command : {"reconstruct", "train", "refine", "prune", "eval", "render", "view", "convert",
                                    "doctor", "report", "config", "bundle_adjust"}) {
    SCOPED_TRACE(command);
    Help({"help", command});
    EXPECT_LE(LongestLine(RunProgram({"help", command, "--all"}).out), 80U);
  }
  EXPECT_THAT(Help({"help", "train"}), HasSubstr("\n  --seed=N                  seed of"));
  EXPECT_THAT(Help({"help", "train"}), HasSubstr("|paper_code\n                            defaults of"));
}

// Counts the lines that begin with a flag.
int CountFlags(const std::string& text) {
  int flags = 0;
  for (std::size_t at = text.find("\n  --"); at != std::string::npos; at = text.find("\n  --", at + 1)) ++flags;
  return flags;
}

TEST(Help, ListsFewFlagsAndWithAllEveryOption) {
  for (const std::string command : {"train", "refine", "config"}) {
    SCOPED_TRACE(command);
    const std::string few = Help({"help", command});
    EXPECT_GE(CountFlags(few), 8);
    EXPECT_LE(CountFlags(few), 20);
    const ProgramOutput all = RunProgram({"help", command, "--all"});
    EXPECT_EQ(all.status, 0);
    EXPECT_EQ(RunProgram({command, "--help", "--all"}).out, all.out);
    for (const auto& field : gs::TrainFields()) {
      const bool is_of_refine = !field.name.starts_with("density.") && !field.name.starts_with("pruning.") &&
                                field.name != "train.sh_degree" && field.name != "train.background" &&
                                field.name != "train.eps2d" && field.name != "train.antialias";
      const std::string line = "\n  " + field.name + "=" + field.Placeholder();
      EXPECT_EQ(all.out.find(line) != std::string::npos, command != "refine" || is_of_refine) << line;
    }
    EXPECT_THAT(all.out, HasSubstr("lm.l1_floor=X"));
    EXPECT_THAT(Unwrapped(all.out), HasSubstr("; from 1e-06 to 1 [0.01]"));
  }
}

TEST(Help, CommandListsItsFlagsAlone) {
  const std::string train = Help({"help", "train"});
  EXPECT_THAT(train, HasSubstr("--preset=fast|balanced|best|paper|paper_code"));
  EXPECT_THAT(train, HasSubstr("--iterations=N"));
  EXPECT_THAT(train, Not(HasSubstr("--truth")));
  EXPECT_EQ(Help({"train", "--help"}), train);
  EXPECT_EQ(Help({"train", "scene", "--out=x", "--help"}), train);

  const std::string refine = Help({"help", "refine"});
  EXPECT_THAT(refine, HasSubstr("--lm_iterations=N"));
  EXPECT_THAT(refine, HasSubstr("--method=views|lm|both"));
  EXPECT_THAT(Unwrapped(refine), HasSubstr("has the SH degree and the number of Gaussians of SPLAT"));
  EXPECT_THAT(train, Not(HasSubstr("SPLAT")));
  const std::string prune = Help({"help", "prune"});
  for (const char* flag : {"--keep=X", "--max_loss=X", "--size_mib=X", "--method="}) {
    EXPECT_THAT(prune, HasSubstr(flag));
  }
  const std::string render = Help({"help", "render"});
  for (const char* flag : {"--truth", "--path=orbit|spiral|photographs|FILE.json", "--film=FILE.mp4",
                           "--show=colour|depth|median_depth|normals"}) {
    EXPECT_THAT(render, HasSubstr(flag));
  }
  EXPECT_THAT(train, HasSubstr("`vesta help train --all` lists more flags, and the keys for --set."));
  EXPECT_THAT(Help({"help", "bundle_adjust"}), HasSubstr("`vesta help bundle_adjust --all` lists more flags."));
  const std::string eval = Help({"help", "eval"});
  EXPECT_THAT(eval, HasSubstr("--json=FILE"));
  EXPECT_THAT(eval, HasSubstr("--align=none|pose|pose+colour"));
  const std::string convert = Help({"help", "convert"});
  EXPECT_THAT(convert, HasSubstr("vesta convert SPLAT --out=FILE"));
  EXPECT_THAT(Unwrapped(convert), HasSubstr(".ply, .compressed.ply, .spz, .splat, .sog or .glb"));
  EXPECT_EQ(CountFlags(convert), 6);
}

}  // namespace
}  // namespace vesta::test
