// SPDX-License-Identifier: Apache-2.0
// The MPI ranks of the program: `mpirun -n P vesta ...`. Implemented in ranks_mpi.cpp, or in ranks_none.cpp without
// MPI.
#pragma once

#include <memory>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta::app {

// Returns the communicator of all ranks; without mpirun, of this process alone. The first call initialises MPI. Throws
// Error if mpirun started several processes of a build without MPI.
Communicator& WorldCommunicator();
// Whether another rank has just reported an error with the message `why`, so that this rank need not print it. May wait
// half a second for such a report.
bool IsReportedByOtherRank(const std::string& why);
// For a rank that fails. If there are other ranks: sends them the reason `why` and exits with `status` at once, because
// MPI_Finalize would wait forever. Returns if this rank is alone.
void AbortOtherRanks(const std::string& why, int status);
// Waits for all ranks. Collective: every rank calls it at the end of the program, so that no rank succeeds if another
// one fails.
void WaitForOtherRanks();
// Prefix of messages: "process 2 of 4: " with several ranks, else empty.
std::string RankPrefix();

// True on rank 0, which prints and writes files.
inline bool IsFirstRank() { return WorldCommunicator().rank() == 0; }
// Calls body on rank 0 first, then on the other ranks, and returns its result. If body throws on rank 0, the other
// ranks stop too, so an error that all ranks have is reported once.
template <class Body>
auto FirstRankFirst(const Body& body) {
  if (!IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  auto result = body();
  if (IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  return result;
}

}  // namespace vesta::app
