// The commands. Each takes its arguments (as many as the table in flags.cpp says), reads its own flags, prints to
// stdout, and returns the exit status. Throws Error for input that cannot be used.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

using Arguments = std::vector<std::string>;

// Exit status after Ctrl-C: 128 + SIGINT, as shells have it. Results are written all the same.
inline constexpr int kInterruptedStatus = 130;

int RunTrain(const Arguments& arguments);
int RunRefine(const Arguments& arguments);
int RunEval(const Arguments& arguments);
int RunRender(const Arguments& arguments);
int RunBundleAdjust(const Arguments& arguments);

}  // namespace vesta::app
