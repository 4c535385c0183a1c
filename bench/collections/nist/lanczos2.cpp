// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Lanczos2 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    2.5134, 0, 2.04433, 0.05, 1.6684, 0.1, 1.36642, 0.15, 1.12323, 0.2, 0.92689, 0.25, 0.767934, 0.3,
    0.638878, 0.35, 0.533784, 0.4, 0.447936, 0.45, 0.377585, 0.5, 0.319739, 0.55, 0.272013, 0.6, 0.232497, 0.65,
    0.199659, 0.7, 0.17227, 0.75, 0.149341, 0.8, 0.13007, 0.85, 0.113812, 0.9, 0.100042, 0.95, 0.0883321, 1,
    0.0783354, 1.05, 0.0697669, 1.1, 0.0623931, 1.15,
};
// clang-format on
constexpr double kStart1[] = {1.2, 0.3, 5.6, 5.5, 6.5, 7.6};
constexpr double kStart2[] = {0.5, 0.7, 3.6, 4.2, 4, 6.3};
constexpr double kCertified[] = {0.096251029939, 1.0057332849, 0.86424689056, 3.0078283915, 1.5529016879, 5.00287981};
constexpr double kDeviation[] = {0.00066770575477, 0.0033989646176, 0.0017185846685,
                                 0.0041707005856,  0.0023744381417, 0.0013958787284};

}  // namespace

const Problem kLanczos2 = {"Lanczos2", Difficulty::kAverage, 1,          kRows,           kStart1,
                           kStart2,    kCertified,           kDeviation, 2.2299428125e-11};

}  // namespace vesta::nist
