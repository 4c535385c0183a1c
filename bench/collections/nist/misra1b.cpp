// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Misra1b (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    10.07, 77.6, 14.73, 114.9, 17.94, 141.1, 23.93, 190.8, 29.61, 239.9, 35.18, 289, 40.02, 332.8, 44.82, 378.4,
    50.76, 434.8, 55.05, 477.3, 61.01, 536.8, 66.4, 593.1, 75.47, 689.1, 81.78, 760,
};
// clang-format on
constexpr double kStart1[] = {500, 0.0001};
constexpr double kStart2[] = {300, 0.0002};
constexpr double kCertified[] = {337.99746163, 0.00039039091287};
constexpr double kDeviation[] = {3.1643950207, 0.0000042547321834};

}  // namespace

const Problem kMisra1b = {"Misra1b", Difficulty::kLower, 1,          kRows,         kStart1,
                          kStart2,   kCertified,         kDeviation, 0.075464681533};

}  // namespace vesta::nist
