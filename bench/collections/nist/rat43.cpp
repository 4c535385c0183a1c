// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Rat43 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    16.08, 1, 33.83, 2, 65.8, 3, 97.2, 4, 191.55, 5, 326.2, 6, 386.87, 7, 520.53, 8, 590.03, 9, 651.92, 10,
    724.93, 11, 699.56, 12, 689.96, 13, 637.56, 14, 717.41, 15,
};
// clang-format on
constexpr double kStart1[] = {100, 10, 1, 1};
constexpr double kStart2[] = {700, 5, 0.75, 1.3};
constexpr double kCertified[] = {699.6415127, 5.2771253025, 0.75962938329, 1.2792483859};
constexpr double kDeviation[] = {16.302297817, 2.0828735829, 0.19566123451, 0.68761936385};

}  // namespace

const Problem kRat43 = {"Rat43", Difficulty::kHigher, 1, kRows, kStart1, kStart2, kCertified, kDeviation, 8786.404908};

}  // namespace vesta::nist
