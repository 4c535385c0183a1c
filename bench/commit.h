// SPDX-License-Identifier: Apache-2.0
// The version of the sources of a benchmark.
#pragma once

namespace vesta::bench {

// The git commit, with "-dirty" if the sources differ from it; "unknown" without git. Updated by every build.
extern const char* const kCommit;

}  // namespace vesta::bench
