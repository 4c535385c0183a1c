// SPDX-License-Identifier: Apache-2.0
// Communicator over MPI: the only place that knows of it. Open MPI and MPICH do.
#pragma once

#include <memory>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta {

struct MpiOptions {
  // Where others are silent for so long, a word about it goes to `warn`; seconds.
  double warn_after = 60;
  void (*warn)(const std::string& line) = nullptr;
};

// All processes of MPI_COMM_WORLD. MPI is initialised here, once a process, and ended with this object, unless a rank
// abandoned the others: then the process must end without MPI_Finalize, by _exit.
//
// Throws Error where MPI cannot start, and where the ranks do not run the same instruction set: their results would not
// be the same bits (VESTA_SIMD chooses one that all have).
std::unique_ptr<Communicator> StartMpi(const MpiOptions& options = {});

}  // namespace vesta
