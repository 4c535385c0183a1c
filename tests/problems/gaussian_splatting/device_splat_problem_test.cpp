// The splatting problem of a GPU, all of it but the driver, on a device made of the host.
#include "problems/gaussian_splatting/lm/device_splat_problem.h"

#include <gtest/gtest.h>

#include "tests/cuda/splat_checks.h"

namespace vesta {
namespace {

TEST(EmulatedDevice, ViewsAreThoseOfTheHost) { test::ExpectViewsOfTheHost(); }
TEST(EmulatedDevice, TheLossIsThatOfTheHost) { test::ExpectLossOfTheHost(); }
TEST(EmulatedDevice, TheProblemIsThatOfTheHost) { test::ExpectProblemOfTheHost(); }
TEST(EmulatedDevice, ItsVariantsAreThoseOfTheHost) { test::ExpectVariantsOfTheHost(); }

}  // namespace
}  // namespace vesta
