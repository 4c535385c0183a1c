// SPDX-License-Identifier: Apache-2.0
// NIST StRD, MGH09 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    0.1957, 4, 0.1947, 2, 0.1735, 1, 0.16, 0.5, 0.0844, 0.25, 0.0627, 0.167, 0.0456, 0.125, 0.0342, 0.1,
    0.0323, 0.0833, 0.0235, 0.0714, 0.0246, 0.0625,
};
// clang-format on
constexpr double kStart1[] = {25, 39, 41.5, 39};
constexpr double kStart2[] = {0.25, 0.39, 0.415, 0.39};
constexpr double kCertified[] = {0.19280693458, 0.19128232873, 0.12305650693, 0.13606233068};
constexpr double kDeviation[] = {0.011435312227, 0.19633220911, 0.080842031232, 0.090025542308};

}  // namespace

const Problem kMGH09 = {"MGH09", Difficulty::kHigher, 1,          kRows,           kStart1,
                        kStart2, kCertified,          kDeviation, 0.00030750560385};

}  // namespace vesta::nist
