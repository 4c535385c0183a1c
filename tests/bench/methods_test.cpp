// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

using testing::Contains;
using testing::ElementsAre;

std::vector<std::string> Names(std::vector<const char*> flags, int training_views = 17) {
  flags.insert(flags.begin(), "lm_vs_adam");
  std::vector<std::string> known = {"methods", "lengths", "rate_factors", "evaluations"};
  const Arguments arguments(static_cast<int>(flags.size()), const_cast<char**>(flags.data()), known);
  gs::TrainOptions ours = gs::PresetOptions("balanced");
  ours.adam.iterations = 2000;
  ours.adam.lr_scale = 5;
  std::vector<std::string> names;
  for (const Method& method : SelectMethods(arguments, ours, training_views)) {
    gs::ValidateOptions(method.options);
    names.push_back(method.name);
  }
  return names;
}

TEST(SelectMethods, OursFirstThenThoseFromItsState) {
  EXPECT_THAT(Names({"--methods=adam,paper,ours", "--lengths=8000,2000", "--rate_factors=5"}),
              ElementsAre("ours", "our LM", "paper", "paper_code", "adam 2000 x5", "adam 8000 x5"));
}

TEST(SelectMethods, NineSchedulesByDefaultAndOursBesideThem) {
  EXPECT_EQ(Names({"--methods=adam"}).size(), 9u);
  // 16 epochs of many views are longer than the schedule.
  const std::vector<std::string> names = Names({"--methods=adam"}, 250);
  EXPECT_EQ(names.size(), 10u);
  EXPECT_THAT(names, Contains("adam 2000 x5"));
  EXPECT_THAT(names, Contains("adam 16000 x2.5"));
}

TEST(SelectMethods, RefusesWhatItCannotUse) {
  EXPECT_THROW(Names({"--methods=paper"}), Error);
  EXPECT_THROW(Names({"--methods=adams"}), Error);
  EXPECT_THROW(Names({"--lengths=0"}), Error);
  EXPECT_THROW(Names({"--rate_factors=2x"}), Error);
}

}  // namespace
}  // namespace vesta::bench
