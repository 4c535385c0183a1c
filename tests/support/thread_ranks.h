// SPDX-License-Identifier: Apache-2.0
// Ranks that are threads of one process, to test distributed code without MPI and with the thread sanitizer.
#pragma once

#include <functional>

#include "kernels/ranks/communicator.h"

namespace vesta::test {

// Calls body(communicator) on `count` threads, one per rank, and waits for them. If one throws, the other ranks' calls
// to the communicator throw too, and this function rethrows the first exception.
void OnThreadRanks(int count, const std::function<void(Communicator&)>& body);

}  // namespace vesta::test
