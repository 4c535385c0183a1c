// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Roszman1 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    0.252429, -4868.68, 0.252141, -4868.09, 0.251809, -4867.41, 0.297989, -3375.19, 0.296257, -3373.14,
    0.295319, -3372.03, 0.339603, -2473.74, 0.337731, -2472.35, 0.33382, -2469.45, 0.38951, -1894.65,
    0.386998, -1893.4, 0.438864, -1497.24, 0.434887, -1495.85, 0.427893, -1493.41, 0.471568, -1208.68,
    0.461699, -1206.18, 0.461144, -1206.04, 0.513532, -997.92, 0.506641, -996.61, 0.505062, -996.31,
    0.535648, -834.94, 0.533726, -834.66, 0.568064, -710.03, 0.612886, -530.16, 0.624169, -464.17,
};
// clang-format on
constexpr double kStart1[] = {0.1, -0.00001, 1000, -100};
constexpr double kStart2[] = {0.2, -0.000005, 1200, -150};
constexpr double kCertified[] = {0.20196866396, -0.0000061953516256, 1204.4556708, -181.34269537};
constexpr double kDeviation[] = {0.019172666023, 0.0000032058931691, 74.050983057, 49.573513849};

}  // namespace

const Problem kRoszman1 = {"Roszman1", Difficulty::kAverage, 1,          kRows,           kStart1,
                           kStart2,    kCertified,           kDeviation, 0.00049484847331};

}  // namespace vesta::nist
