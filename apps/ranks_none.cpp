// Without MPI.
#include "apps/ranks.h"
#include "kernels/core/check.h"

namespace vesta::app {

Ranks& WorldRanks() {
  static SoloRank alone;
  if (IsStartedInRanks()) {
    Fail("this vesta was started by mpirun, but built without MPI; build it with -DVESTA_MPI=ON, or start it alone");
  }
  return alone;
}

void EndWithOthers(const std::string&, int) {}

void MeetAtEnd() {}

std::string RankPrefix() { return ""; }

}  // namespace vesta::app
