// SPDX-License-Identifier: Apache-2.0
// A communicator whose ranks are threads of one program. Distributed code can be tested without processes, and with the
// thread sanitizer.
#pragma once

#include <functional>

#include "kernels/ranks/communicator.h"

namespace vesta::test {

// Calls body(ranks) on `count` threads, one per rank. If one throws, the others are abandoned and the first exception
// is rethrown.
void OnThreadRanks(int count, const std::function<void(Communicator&)>& body);

}  // namespace vesta::test
