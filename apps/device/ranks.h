// SPDX-License-Identifier: Apache-2.0
// The MPI ranks of the program: `mpirun -n P vesta ...`. Implemented in ranks_mpi.cpp, or in ranks_none.cpp without
// MPI.
#pragma once

#include <memory>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta::app {

// The communicator of all ranks, or of this process alone if mpirun started none. The first call initialises MPI.
// Throws Error if mpirun started several processes of a build without MPI.
Communicator& WorldCommunicator();
// Whether another rank has already reported this error.
bool IsReportedByOtherRank(const std::string& why);
// If other ranks run: sends them the reason, unless they know it, and exits at once, because MPI_Finalize would wait
// forever. Returns if this rank is alone.
void AbortOtherRanks(const std::string& why, int status);
// At the end of the program: waits for the other ranks, so that no rank succeeds if another one fails.
void WaitForOtherRanks();
// "process 2 of 4: " with several ranks, else empty.
std::string RankPrefix();

// Rank 0 prints and writes files.
inline bool IsFirstRank() { return WorldCommunicator().rank() == 0; }
// Runs body on rank 0 before the other ranks start it, so that a common error is reported once. Returns its result.
template <class Body>
auto FirstRankFirst(const Body& body) {
  if (!IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  auto result = body();
  if (IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  return result;
}

}  // namespace vesta::app
