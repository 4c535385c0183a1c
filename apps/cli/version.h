// SPDX-License-Identifier: Apache-2.0
// What this program is, for reports of what it did.
#pragma once

#include <string>

namespace vesta::app {

// The commit it was built from, with -dirty where the sources differed; "unknown" without git. Written with every
// build.
extern const char* const kCommit;

// "0.1.0".
std::string VersionNumber();
// "0.1.0 (commit 1234567)".
std::string Version();
// The same, and the instruction sets: those compiled in, those this CPU has, the one that is used. Two lines.
std::string VersionText();

}  // namespace vesta::app
