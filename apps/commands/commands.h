// SPDX-License-Identifier: Apache-2.0
// The commands of the program. A command prints its results to stdout and returns the exit status. The parser has
// checked the number of arguments. Commands throw Error (one line) for unusable input, and UsageError for an invalid
// combination of flags.
#pragma once

#include "apps/cli/flags.h"

namespace vesta::app {

int RunReconstruct(const CommandLine& line);
int RunTrain(const CommandLine& line);
int RunRefine(const CommandLine& line);
int RunPrune(const CommandLine& line);
int RunEval(const CommandLine& line);
int RunRender(const CommandLine& line);
int RunConvert(const CommandLine& line);
int RunView(const CommandLine& line);
int RunDoctor(const CommandLine& line);
int RunReport(const CommandLine& line);
int RunConfig(const CommandLine& line);
int RunBundleAdjust(const CommandLine& line);
int RunPoseGraph(const CommandLine& line);

}  // namespace vesta::app
