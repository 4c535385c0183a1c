// SPDX-License-Identifier: Apache-2.0
// Builds with MPI.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "apps/cli/print.h"
#include "apps/device/ranks.h"
#include "kernels/mpi/mpi_communicator.h"

namespace vesta::app {
namespace {

std::unique_ptr<Communicator> world;

void Warn(const std::string& line) { PrintText(stderr, "vesta: " + line + "\n"); }

}  // namespace

Communicator& WorldCommunicator() {
  if (!world) {
    if (IsStartedInRanks()) {
      world = StartMpi({.warn = Warn});
    } else {
      world = std::make_unique<SingleRankCommunicator>();
    }
  }
  return *world;
}

bool IsReportedByOtherRank(const std::string& why) {
  try {
    return WorldCommunicator().IsReportedByOtherRank(why);
  } catch (const Error&) {
    return false;  // without MPI every process reports its own error
  }
}

void AbortOtherRanks(const std::string& why, int status) {
  if (!world || world->size() == 1) return;
  world->Abandon(why);
  std::fflush(stdout);
  // MPI_Finalize would wait for calls that other ranks never make.
  _exit(status);
}

void WaitForOtherRanks() {
  if (world) OnAnyRank(*world, false);
}

std::string RankPrefix() {
  return world && world->size() > 1 ? fmt::format("process {} of {}: ", world->rank(), world->size()) : "";
}

}  // namespace vesta::app
