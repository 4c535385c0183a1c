// SPDX-License-Identifier: Apache-2.0
// Growth of rounding errors in float, on the host.
#include "tests/kernels/gaussian_splatting/error_growth.h"

namespace vesta::test {
namespace {

class ErrorGrowth : public testing::TestWithParam<Growth> {};
INSTANTIATE_TEST_SUITE_P(InFloat, ErrorGrowth, testing::ValuesIn(Growths()),
                         [](const auto& param) { return param.param.name; });

TEST_P(ErrorGrowth, StaysWithinItsBound) { CheckGrowth<RenderedView<float>>(GetParam().scene); }

}  // namespace
}  // namespace vesta::test
