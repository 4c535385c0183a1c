// SPDX-License-Identifier: Apache-2.0
// The commands. Each reads its own arguments (as many as the table in flags.cpp says) and flags, prints to stdout, and
// returns the exit status. Throws Error for input that cannot be used.
#pragma once

#include "apps/cli/flags.h"

namespace vesta::app {

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

}  // namespace vesta::app
