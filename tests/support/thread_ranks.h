// SPDX-License-Identifier: Apache-2.0
// Communicator that are threads of one program, so that what is spread over processes can be tested without any, and
// under the thread sanitizer.
#pragma once

#include <functional>

#include "kernels/ranks/communicator.h"

namespace vesta::test {

// Calls body(ranks) on `count` threads, each a rank. An exception of one abandons the others; the first is rethrown.
void OnThreadRanks(int count, const std::function<void(Communicator&)>& body);

}  // namespace vesta::test
