// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace vesta {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

testing::Matcher<PhaseRow> Row(const char* name, int depth, int calls, double wall, double cpu) {
  return AllOf(Field(&PhaseRow::name, name), Field(&PhaseRow::depth, depth), Field(&PhaseRow::calls, calls),
               Field(&PhaseRow::seconds, AllOf(Field(&PhaseSeconds::wall, wall), Field(&PhaseSeconds::cpu, cpu))));
}

// The test controls the clock.
class ProfileTest : public testing::Test {
 protected:
  void Work(double wall, double cpu) { now_ += {wall, cpu}; }
  PhaseSeconds now_{100, 50};
  Profile profile_{[this] { return now_; }};
};

TEST_F(ProfileTest, RowsOfADepthAddUpToTheirParent) {
  Work(1, 1);  // before the scope
  {
    const ProfileScope scope(&profile_);
    Work(2, 3);
    for (int i = 0; i < 2; ++i) {
      const ScopedPhase solve("solve");
      Work(1, 1);
      ScopedPhase phase("sort");
      Work(4, 8);
      phase.Next("raster");
      Work(8, 16);
    }
    const ScopedPhase sort("sort");  // with another parent
    Work(16, 16);
  }
  Work(1, 1);  // after it
  EXPECT_THAT(profile_.Rows(0),
              ElementsAre(Row("total", 0, 1, 44, 69), Row("solve", 1, 2, 26, 50), Row("raster", 2, 2, 16, 32),
                          Row("sort", 2, 2, 8, 16), Row("other", 2, 0, 2, 2), Row("sort", 1, 1, 16, 16),
                          Row("other", 1, 0, 2, 3)));
}

TEST_F(ProfileTest, SmallPhasesAreOther) {
  const ProfileScope scope(&profile_);
  Work(90, 90);
  {
    const ScopedPhase phase("small");
    Work(10, 5);
  }
  EXPECT_THAT(profile_.Rows(0.11), ElementsAre(Row("total", 0, 1, 100, 95)));
  EXPECT_THAT(profile_.Rows(0.1),
              ElementsAre(Row("total", 0, 1, 100, 95), Row("small", 1, 1, 10, 5), Row("other", 1, 0, 90, 90)));
  EXPECT_THAT(ProfileTable(profile_.Rows(0.1)), HasSubstr("  small                               1    10.000   10.0"));
}

TEST_F(ProfileTest, RowsIncludeOpenPhases) {
  const ProfileScope scope(&profile_);
  const ScopedPhase phase("long");
  Work(3, 1);
  EXPECT_THAT(profile_.Rows(),
              ElementsAre(Row("total", 0, 1, 3, 1), Row("long", 1, 1, 3, 1), Row("other", 1, 0, 0, 0)));
}

TEST_F(ProfileTest, RecordsOnlyItsThreadWithinItsScope) {
  {
    const ScopedPhase phase("outside");
    Work(1, 1);
  }
  const ProfileScope scope(&profile_);
  std::thread([&] {
    EXPECT_EQ(Profile::Current(), nullptr);
    const ScopedPhase phase("of another thread");
  }).join();
  {
    const ProfileScope none(nullptr);
    EXPECT_EQ(Profile::Current(), &profile_);
    Profile other([this] { return now_; });
    const ProfileScope inner(&other);
    const ScopedPhase phase("of the inner profile");
    Work(1, 1);
  }
  EXPECT_EQ(Profile::Current(), &profile_);
  EXPECT_THAT(profile_.Rows(), ElementsAre(Row("total", 0, 1, 1, 1)));
}

TEST(ReadClocks, GoOn) {
  const PhaseSeconds before = ReadClocks();
  const PhaseSeconds after = ReadClocks();
  EXPECT_GE(after.wall, before.wall);
  EXPECT_GE(after.cpu, before.cpu);
  EXPECT_GT(after.cpu, 0.0);
}

}  // namespace
}  // namespace vesta
