// SPDX-License-Identifier: Apache-2.0
// NIST StRD, nonlinear regression, Thurber (itl.nist.gov/div898/strd; public domain).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    80.574, -3.067, 84.248, -2.981, 87.264, -2.921, 87.195, -2.912, 89.076, -2.84, 89.608, -2.797,
    89.868, -2.702, 90.101, -2.699, 92.405, -2.633, 95.854, -2.481, 100.696, -2.363, 101.06, -2.322,
    401.672, -1.501, 390.724, -1.46, 567.534, -1.274, 635.316, -1.212, 733.054, -1.1, 759.087, -1.046,
    894.206, -0.915, 990.785, -0.714, 1090.109, -0.566, 1080.914, -0.545, 1122.643, -0.4, 1178.351, -0.309,
    1260.531, -0.109, 1273.514, -0.103, 1288.339, 0.01, 1327.543, 0.119, 1353.863, 0.377, 1414.509, 0.79,
    1425.208, 0.963, 1421.384, 1.006, 1442.962, 1.115, 1464.35, 1.572, 1468.705, 1.841, 1447.894, 2.047,
    1457.628, 2.2,
};
// clang-format on
constexpr double kStart1[] = {1000, 1000, 400, 40, 0.7, 0.3, 0.03};
constexpr double kStart2[] = {1300, 1500, 500, 75, 1, 0.4, 0.05};
constexpr double kCertified[] = {1288.13968,    1491.0792535,  583.23836877,  75.416644291,
                                 0.96629502864, 0.39797285797, 0.049727297349};
constexpr double kDeviation[] = {4.6647963344,   39.571156086,   28.698696102,   5.567537027,
                                 0.031333340687, 0.014984928198, 0.0065842344623};

}  // namespace

const Problem kThurber = {"Thurber", Difficulty::kHigher, 1,          kRows,       kStart1,
                          kStart2,   kCertified,          kDeviation, 5642.7082397};

}  // namespace vesta::nist
