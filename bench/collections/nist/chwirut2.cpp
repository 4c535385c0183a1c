// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Chwirut2 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    92.9, 0.5, 57.1, 1, 31.05, 1.75, 11.5875, 3.75, 8.025, 5.75, 63.6, 0.875, 21.4, 2.25, 14.25, 3.25,
    8.475, 5.25, 63.8, 0.75, 26.8, 1.75, 16.4625, 2.75, 7.125, 4.75, 67.3, 0.625, 41, 1.25, 21.15, 2.25,
    8.175, 4.25, 81.5, 0.5, 13.12, 3, 59.9, 0.75, 14.62, 3, 32.9, 1.5, 5.44, 6, 12.56, 3, 5.44, 6, 32, 1.5,
    13.95, 3, 75.8, 0.5, 20, 2, 10.42, 4, 59.5, 0.75, 21.67, 2, 8.55, 5, 62, 0.75, 20.2, 2.25, 7.76, 3.75,
    3.75, 5.75, 11.81, 3, 54.7, 0.75, 23.7, 2.5, 11.55, 4, 61.3, 0.75, 17.7, 2.5, 8.74, 4, 59.2, 0.75,
    16.3, 2.5, 8.62, 4, 81, 0.5, 4.87, 6, 14.62, 3, 81.7, 0.5, 17.17, 2.75, 81.3, 0.5, 28.9, 1.75,
};
// clang-format on
constexpr double kStart1[] = {0.1, 0.01, 0.02};
constexpr double kStart2[] = {0.15, 0.008, 0.01};
constexpr double kCertified[] = {0.16657666537, 0.0051653291286, 0.012150007096};
constexpr double kDeviation[] = {0.03830328681, 0.00066621605126, 0.0015304234767};

}  // namespace

const Problem kChwirut2 = {"Chwirut2", Difficulty::kLower, 1,          kRows,       kStart1,
                           kStart2,    kCertified,         kDeviation, 513.04802941};

}  // namespace vesta::nist
