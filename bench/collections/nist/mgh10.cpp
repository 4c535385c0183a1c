// SPDX-License-Identifier: Apache-2.0
// NIST StRD, MGH10 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    34780, 50, 28610, 55, 23650, 60, 19630, 65, 16370, 70, 13720, 75, 11540, 80, 9744, 85, 8261, 90, 7030, 95,
    6005, 100, 5147, 105, 4427, 110, 3820, 115, 3307, 120, 2872, 125,
};
// clang-format on
constexpr double kStart1[] = {2, 400000, 25000};
constexpr double kStart2[] = {0.02, 4000, 250};
constexpr double kCertified[] = {0.005609636471, 6181.3463463, 345.22363462};
constexpr double kDeviation[] = {0.00015687892471, 23.309021107, 0.78486103508};

}  // namespace

const Problem kMGH10 = {"MGH10", Difficulty::kHigher, 1, kRows, kStart1, kStart2, kCertified, kDeviation, 87.945855171};

}  // namespace vesta::nist
