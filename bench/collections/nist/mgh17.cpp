// SPDX-License-Identifier: Apache-2.0
// NIST StRD, MGH17 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    0.844, 0, 0.908, 10, 0.932, 20, 0.936, 30, 0.925, 40, 0.908, 50, 0.881, 60, 0.85, 70, 0.818, 80, 0.784, 90,
    0.751, 100, 0.718, 110, 0.685, 120, 0.658, 130, 0.628, 140, 0.603, 150, 0.58, 160, 0.558, 170, 0.538, 180,
    0.522, 190, 0.506, 200, 0.49, 210, 0.478, 220, 0.467, 230, 0.457, 240, 0.448, 250, 0.438, 260, 0.431, 270,
    0.424, 280, 0.42, 290, 0.414, 300, 0.411, 310, 0.406, 320,
};
// clang-format on
constexpr double kStart1[] = {50, 150, -100, 1, 2};
constexpr double kStart2[] = {0.5, 1.5, -1, 0.01, 0.02};
constexpr double kCertified[] = {0.37541005211, 1.9358469127, -1.4646871366, 0.01286753464, 0.022122699662};
constexpr double kDeviation[] = {0.0020723153551, 0.22031669222, 0.22175707739, 0.00044861358114, 0.00089471996575};

}  // namespace

const Problem kMGH17 = {"MGH17",    Difficulty::kAverage, 1, kRows, kStart1, kStart2, kCertified,
                        kDeviation, 0.000054648946975};

}  // namespace vesta::nist
