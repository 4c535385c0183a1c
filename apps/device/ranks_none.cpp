// SPDX-License-Identifier: Apache-2.0
// Builds without MPI.
#include "apps/device/ranks.h"
#include "kernels/core/check.h"

namespace vesta::app {

Communicator& WorldCommunicator() {
  static SingleRankCommunicator alone;
  if (NumStartedRanks() > 1) {
    Fail(kUnavailable,
         "this vesta was started by mpirun, but built without MPI; build it with -DVESTA_MPI=ON, or start it without "
         "mpirun");
  }
  return alone;
}

bool IsReportedByOtherRank(const std::string&) { return false; }

void AbortOtherRanks(const std::string&, int) {}

void WaitForOtherRanks() {}

std::string RankPrefix() { return ""; }

}  // namespace vesta::app
