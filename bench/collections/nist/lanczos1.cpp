// SPDX-License-Identifier: Apache-2.0
// NIST StRD, Lanczos1 (nist_data.h).
#include "bench/collections/nist_data.h"

namespace vesta::nist {
namespace {

// y, x of each observation.
// clang-format off
constexpr double kRows[] = {
    2.5134, 0, 2.044333373291, 0.05, 1.668404436564, 0.1, 1.366418021208, 0.15, 1.123232487372, 0.2,
    0.9268897180037, 0.25, 0.7679338563728, 0.3, 0.6388775523106, 0.35, 0.5337835317402, 0.4,
    0.4479363617347, 0.45, 0.377584788435, 0.5, 0.3197393199326, 0.55, 0.2720130773746, 0.6,
    0.2324965529032, 0.65, 0.1996589546065, 0.7, 0.1722704126914, 0.75, 0.1493405660168, 0.8,
    0.1300700206922, 0.85, 0.1138119324644, 0.9, 0.1000415587559, 0.95, 0.0883320908454, 1,
    0.0783354401935, 1.05, 0.06976693743449, 1.1, 0.06239312536719, 1.15,
};
// clang-format on
constexpr double kStart1[] = {1.2, 0.3, 5.6, 5.5, 6.5, 7.6};
constexpr double kStart2[] = {0.5, 0.7, 3.6, 4.2, 4, 6.3};
constexpr double kCertified[] = {0.095100000027, 1.0000000001, 0.86070000013, 3.0000000002, 1.5575999998, 5.0000000001};
constexpr double kDeviation[] = {5.3347304234e-11, 2.7473038179e-10, 1.3576062225e-10,
                                 3.3308253069e-10, 1.8815731448e-10, 1.1057500538e-10};

}  // namespace

const Problem kLanczos1 = {"Lanczos1", Difficulty::kAverage, 1,          kRows,           kStart1,
                           kStart2,    kCertified,           kDeviation, 1.4307867721e-25};

}  // namespace vesta::nist
