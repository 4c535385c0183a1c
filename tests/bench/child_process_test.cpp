// SPDX-License-Identifier: Apache-2.0
#include "bench/child_process.h"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>
#include <vector>

namespace vesta::bench {
namespace {

TEST(RunInChild, BringsBackWhatWasSent) {
  // More than a pipe can buffer.
  const std::string sent(200'000, 'x');
  const ChildResult result = RunInChild("child", [&](const Send& send) {
    send("one ", 4);
    send(sent.data(), sent.size());
  });
  EXPECT_FALSE(result.failed);
  EXPECT_TRUE(result.bytes == "one " + sent);
}

TEST(RunInChild, SaysThatTheWorkFailed) {
  EXPECT_TRUE(RunInChild("child", [](const Send&) { throw std::runtime_error("planted"); }).failed);
  const ChildResult killed = RunInChild("child", [](const Send& send) {
    send("some", 4);
    std::raise(SIGKILL);
  });
  EXPECT_TRUE(killed.failed);
  EXPECT_EQ(killed.bytes, "some");
}

TEST(RunInChild, PeakMemoryIsTheChilds) {
  const auto peak = [](std::size_t mib) {
    return RunInChild("child",
                      [mib](const Send& send) {
                        const std::vector<char> memory(mib << 20, 'm');
                        send(&memory[mib], 1);
                      })
        .peak_mib;
  };
  const double little = peak(1), much = peak(65);
  EXPECT_GT(much, little + 60);
  EXPECT_LT(much, little + 130);
  EXPECT_LT(peak(1), little + 10) << "the second child must not count the first one's memory";
}

}  // namespace
}  // namespace vesta::bench
