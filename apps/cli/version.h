// SPDX-License-Identifier: Apache-2.0
// The version of the program, its commit and instruction sets.
#pragma once

#include <string>

namespace vesta::app {

// The git commit of the sources, with "-dirty" if they differ from it; "unknown" without git. Updated by every build.
extern const char* const kCommit;

// Such as "0.2.0".
std::string VersionNumber();
// Such as "0.2.0 (commit 1234567)".
std::string Version();
// The text of `vesta --version`, two lines: Version(), and the instruction sets that are compiled in, that this CPU
// supports, and that are used.
std::string VersionText();

}  // namespace vesta::app
