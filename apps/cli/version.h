// SPDX-License-Identifier: Apache-2.0
// Version of the program, its commit and instruction sets.
#pragma once

#include <string>

namespace vesta::app {

// Git commit, with "-dirty" if the sources differ from the commit; "unknown" without git. Every build updates it.
extern const char* const kCommit;

// Such as "0.2.0".
std::string VersionNumber();
// Such as "0.2.0 (commit 1234567)".
std::string Version();
// The text of `vesta --version`: Version(), and the instruction sets compiled in, supported by this CPU, and used.
std::string VersionText();

}  // namespace vesta::app
