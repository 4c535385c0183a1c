// SPDX-License-Identifier: Apache-2.0
// The MPI ranks of `mpirun -n P vesta ...`. Implemented in ranks_mpi.cpp, or in ranks_none.cpp without MPI.
#pragma once

#include <memory>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta::app {

// All ranks; without mpirun, this process alone. The first call initialises MPI. Throws Error if the build has no MPI
// but mpirun started several processes.
Communicator& WorldCommunicator();
// Whether another rank has just reported the error `why`. This rank then need not report it. May wait half a second.
bool IsReportedByOtherRank(const std::string& why);
// For a rank that fails. If there are other ranks, sends them the reason `why` and exits with `status` at once, because
// MPI_Finalize would wait forever. Otherwise returns.
void AbortOtherRanks(const std::string& why, int status);
// Collective: every rank calls it at the end of the program, so that no rank succeeds if another one fails.
void WaitForOtherRanks();
// Prefix of messages: "process 2 of 4: " with several ranks, else empty.
std::string RankPrefix();

// Rank 0 prints and writes files.
inline bool IsFirstRank() { return WorldCommunicator().rank() == 0; }
// Calls body on rank 0 first, then on the others, and returns its result. If body throws on rank 0, the others stop
// too, so a common error is reported once.
template <class Body>
auto FirstRankFirst(const Body& body) {
  if (!IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  auto result = body();
  if (IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  return result;
}

}  // namespace vesta::app
