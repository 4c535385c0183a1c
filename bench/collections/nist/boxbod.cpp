// SPDX-License-Identifier: Apache-2.0
// NIST StRD, BoxBOD (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    109, 1, 149, 2, 149, 3, 191, 5, 213, 7, 224, 10,
};
// clang-format on
constexpr double kStart1[] = {1, 1};
constexpr double kStart2[] = {100, 0.75};
constexpr double kCertified[] = {213.80940889, 0.54723748542};
constexpr double kDeviation[] = {12.354515176, 0.10455993237};

}  // namespace

const Problem kBoxBOD = {"BoxBOD", Difficulty::kHigher, 1,          kRows,       kStart1,
                         kStart2,  kCertified,          kDeviation, 1168.0088766};

}  // namespace vesta::nist
