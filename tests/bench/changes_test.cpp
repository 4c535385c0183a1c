#include "bench/training_race/changes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

using testing::HasSubstr;

TEST(Changed, SetsMultipliesAndTakesRooms) {
  gs::TrainOptions options;
  options.lm.initial_lambda = 0.5;
  options.adam.iterations = 10;
  const gs::TrainOptions changed = Changed(options, "lm.initial_lambda=x0.5 adam.iterations=x0.25 lm.jacobian=cache16");
  EXPECT_EQ(changed.lm.initial_lambda, 0.25);
  EXPECT_EQ(changed.adam.iterations, 2);
  EXPECT_EQ(changed.lm.jacobian, gs::JacobianKind::kCache16);
  EXPECT_EQ(Changed(options, "adam.iterations=x0.01").adam.iterations, 1);
  EXPECT_EQ(Changed(options, "lm=paper").lm.initial_lambda, gs::PresetOptions("paper").lm.initial_lambda);
  EXPECT_EQ(Changed(options, "lm=paper").adam.iterations, 10);
}

TEST(Changed, RefusesWhatIsNoChange) {
  const auto message_of = [](const char* changes) -> std::string {
    try {
      Changed({}, changes);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message_of("lm.initial_lambda"), HasSubstr("KEY=VALUE"));
  EXPECT_THAT(message_of("lm.initial_gamma=1"), HasSubstr("no option lm.initial_gamma"));
  EXPECT_THAT(message_of("lm.initial_lambda=large"), HasSubstr("it must be from"));
  EXPECT_THAT(message_of("lm.jacobian=x2"), HasSubstr("it must be recompute"));
  EXPECT_THAT(message_of("lm=slow"), HasSubstr("it must be one of fast"));
}

}  // namespace
}  // namespace vesta::bench
