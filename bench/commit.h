// SPDX-License-Identifier: Apache-2.0
// The sources that a benchmark was built from.
#pragma once

namespace vesta::bench {

// The commit, with -dirty if the sources differ from it; "unknown" without git. Updated by every build.
extern const char* const kCommit;

}  // namespace vesta::bench
