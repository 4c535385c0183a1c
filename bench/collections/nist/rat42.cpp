// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Rat42 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    8.93, 9, 10.8, 14, 18.59, 21, 22.33, 28, 39.35, 42, 56.11, 57, 61.73, 63, 64.62, 70, 67.08, 79,
};
// clang-format on
constexpr double kStart1[] = {100, 1, 0.1};
constexpr double kStart2[] = {75, 2.5, 0.07};
constexpr double kCertified[] = {72.462237576, 2.6180768402, 0.067359200066};
constexpr double kDeviation[] = {1.7340283401, 0.088295217536, 0.0034465663377};

}  // namespace

const Problem kRat42 = {"Rat42", Difficulty::kHigher, 1, kRows, kStart1, kStart2, kCertified, kDeviation, 8.0565229338};

}  // namespace vesta::nist
