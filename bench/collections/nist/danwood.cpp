// SPDX-License-Identifier: Apache-2.0
// NIST StRD, DanWood (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    2.138, 1.309, 3.421, 1.471, 3.597, 1.49, 4.34, 1.565, 4.882, 1.611, 5.66, 1.68,
};
// clang-format on
constexpr double kStart1[] = {1, 5};
constexpr double kStart2[] = {0.7, 4};
constexpr double kCertified[] = {0.76886226176, 3.8604055871};
constexpr double kDeviation[] = {0.01828197386, 0.051726610913};

}  // namespace

const Problem kDanWood = {"DanWood", Difficulty::kLower, 1,          kRows,          kStart1,
                          kStart2,   kCertified,         kDeviation, 0.0043173084083};

}  // namespace vesta::nist
