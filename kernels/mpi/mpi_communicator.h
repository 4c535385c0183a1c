// SPDX-License-Identifier: Apache-2.0
// Communicator over MPI (Open MPI or MPICH). No other file uses MPI.
#pragma once

#include <memory>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta {

struct MpiOptions {
  // If a collective call waits longer than this time, in seconds, `warn` (may be null) is called once.
  double warn_after = 60;
  void (*warn)(const std::string& line) = nullptr;
};

// Starts MPI and returns the communicator of all processes of MPI_COMM_WORLD. May be called once per process. The
// destructor calls MPI_Finalize, unless a rank has called Abandon. In that case, MPI_Finalize could wait forever, so
// the process must end with _exit.
//
// Throws Error if MPI cannot start, or if the ranks use different instruction sets, because their results would then
// differ in some bits (VESTA_SIMD selects a common instruction set).
std::unique_ptr<Communicator> StartMpi(const MpiOptions& options = {});

}  // namespace vesta
