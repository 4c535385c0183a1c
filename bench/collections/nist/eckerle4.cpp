// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Eckerle4 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    0.0001575, 400, 0.0001699, 405, 0.000235, 410, 0.0003102, 415, 0.0004917, 420, 0.000871, 425,
    0.0017418, 430, 0.00464, 435, 0.0065895, 436.5, 0.0097302, 438, 0.0149002, 439.5, 0.023731, 441,
    0.0401683, 442.5, 0.0712559, 444, 0.1264458, 445.5, 0.2073413, 447, 0.2902366, 448.5, 0.3445623, 450,
    0.3698049, 451.5, 0.3668534, 453, 0.3106727, 454.5, 0.2078154, 456, 0.1164354, 457.5, 0.0616764, 459,
    0.03372, 460.5, 0.0194023, 462, 0.0117831, 463.5, 0.0074357, 465, 0.0022732, 470, 0.00088, 475,
    0.0004579, 480, 0.0002345, 485, 0.0001586, 490, 0.0001143, 495, 0.000071, 500,
};
// clang-format on
constexpr double kStart1[] = {1, 10, 500};
constexpr double kStart2[] = {1.5, 5, 450};
constexpr double kCertified[] = {1.5543827178, 4.0888321754, 451.54121844};
constexpr double kDeviation[] = {0.015408051163, 0.046803020753, 0.046800518816};

}  // namespace

const Problem kEckerle4 = {"Eckerle4", Difficulty::kHigher, 1,          kRows,          kStart1,
                           kStart2,    kCertified,          kDeviation, 0.0014635887487};

}  // namespace vesta::nist
