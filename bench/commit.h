// SPDX-License-Identifier: Apache-2.0
// The sources that a benchmark was built from.
#pragma once

namespace vesta::bench {

// The commit, with -dirty where the sources differed from it; "unknown" without git. Written with every build.
extern const char* const kCommit;

}  // namespace vesta::bench
