// SPDX-License-Identifier: Apache-2.0
// The processes that a program runs in together: `mpirun -n P vesta ...`. ranks_mpi.cpp or ranks_none.cpp, as the build
// has MPI or not.
#pragma once

#include <memory>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta::app {

// All processes, where mpirun or alike started several; else this one alone. The first call begins MPI. Throws Error
// where processes were started together by a program that was built without MPI.
Communicator& WorldCommunicator();
// Whether another process has said the same, so that it need not be said again.
bool IsKnownToOthers(const std::string& why);
// Where there are others, tells them why this process ends, unless they know, and ends it at once, since MPI would wait
// for ever. Alone it returns.
void EndWithOthers(const std::string& why, int status);
// At the end of the program: waits for the others, so that none ends well where another does not.
void MeetAtEnd();
// Its name among several, "process 2 of 4: "; alone nothing.
std::string RankPrefix();

// The first of the processes prints and writes files.
inline bool IsFirstRank() { return WorldCommunicator().rank() == 0; }
// What body gives, of the first process before the others begin: what is wrong for all is said once.
template <class Body>
auto FirstRankFirst(const Body& body) {
  if (!IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  auto result = body();
  if (IsFirstRank()) OnAnyRank(WorldCommunicator(), false);
  return result;
}

}  // namespace vesta::app
