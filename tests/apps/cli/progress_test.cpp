// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "apps/cli/print.h"

namespace vesta::app {
namespace {

using testing::HasSubstr;
using testing::Not;

gs::TrainProgress At(int iteration, double seconds) {
  gs::TrainProgress progress;
  progress.iteration = iteration;
  progress.iterations = 100;
  progress.seconds = seconds;
  progress.cost = 0.125;
  progress.psnr = 21.5;
  progress.gaussians = 12345;
  return progress;
}

void Train(ProgressLine* line) {
  for (const int iteration : {0, 1, 25, 50, 100}) line->Update(At(iteration, iteration));
  line->Finish();
}

// For a terminal with this number of columns.
std::string OnTerminal(unsigned short columns) {
  int master = -1, slave = -1;
  winsize size{};
  size.ws_col = columns;
  size.ws_row = 24;
  if (openpty(&master, &slave, nullptr, nullptr, &size) != 0) return "";
  std::FILE* out = fdopen(slave, "w");
  ProgressLine line(out);
  Train(&line);
  std::fclose(out);
  std::string text;
  char part[512];
  for (ssize_t got; (got = ::read(master, part, sizeof(part))) > 0;) text.append(part, static_cast<std::size_t>(got));
  ::close(master);
  return text;
}

TEST(ProgressLine, IsABarOnATerminal) {
  const std::string text = OnTerminal(120);
  if (text.empty()) GTEST_SKIP() << "no pseudo-terminal on this machine";
  EXPECT_THAT(text, HasSubstr("\radam   0 %  ? left  [......"));
  EXPECT_THAT(
      text,
      HasSubstr("adam  25 %  1:15 left  [######..................]   25/100  training PSNR 21.50  12345 Gaussians"));
  EXPECT_THAT(text, HasSubstr("adam 100 %  0:00 left  [########################]"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << "one line, ended once";
}

TEST(ProgressLine, FitsANarrowTerminal) {
  const std::string text = OnTerminal(40);
  if (text.empty()) GTEST_SKIP() << "no pseudo-terminal on this machine";
  EXPECT_THAT(text, HasSubstr("\radam  50 %  0:50 left  [############"));
  for (std::size_t at = text.find('\r'), end; at != std::string::npos; at = end) {
    end = text.find('\r', at + 1);
    const std::string shown = text.substr(at + 1, text.find('\033', at) - at - 1);
    EXPECT_LT(shown.size(), 40u) << shown;
    if (text.find('\033', at) == std::string::npos) break;
  }
}

TEST(ProgressLine, IsPlainLinesInAFile) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  ProgressLine line(file);
  Train(&line);
  std::string text(4096, '\0');
  std::rewind(file);
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  EXPECT_THAT(text,
              HasSubstr("adam  50/100  training loss 0.12500  training PSNR 21.50  12345 Gaussians  0:50 left\n"));
  EXPECT_THAT(text, Not(HasSubstr("\r")));
  EXPECT_THAT(text, Not(HasSubstr("[")));
}

gs::TrainProgress At(gs::Stage stage, int iteration, double seconds) {
  gs::TrainProgress progress;
  progress.stage = stage;
  progress.iteration = iteration, progress.iterations = 10;
  progress.seconds = seconds;
  return progress;
}

// The first iteration has no start time; the second stage starts where the first one ended.
TEST(TimeLeft, FollowsFromWhatHasBeenSeenOfTheStage) {
  TimeLeft left;
  EXPECT_TRUE(std::isnan(left.Observe(At(gs::Stage::kAdam, 1, 100))));
  EXPECT_DOUBLE_EQ(left.Observe(At(gs::Stage::kAdam, 3, 104)), 2 * 7);
  gs::TrainProgress predicted = At(gs::Stage::kAdam, 4, 106);
  predicted.seconds_left = 40;
  EXPECT_DOUBLE_EQ(left.Observe(predicted), 40);
  EXPECT_DOUBLE_EQ(left.Observe(At(gs::Stage::kAdam, 10, 118)), 0);
  EXPECT_DOUBLE_EQ(left.Observe(At(gs::Stage::kLm, 1, 123)), 5 * 9);
}

}  // namespace

}  // namespace vesta::app
