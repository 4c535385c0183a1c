// SPDX-License-Identifier: Apache-2.0
// The version of the program, its commit and instruction sets.
#pragma once

#include <string>

namespace vesta::app {

// The commit of the sources, with -dirty if they were modified; "unknown" without git. Updated by every build.
extern const char* const kCommit;

// "0.2.0".
std::string VersionNumber();
// "0.2.0 (commit 1234567)".
std::string Version();
// Two lines: the version, and the instruction sets that are compiled in, supported by this CPU, and used.
std::string VersionText();

}  // namespace vesta::app
