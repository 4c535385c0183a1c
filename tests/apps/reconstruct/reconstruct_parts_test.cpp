// SPDX-License-Identifier: Apache-2.0
// Decisions of vesta reconstruct: frames of a film, cameras, pairs to match.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "apps/reconstruct/camera_groups.h"
#include "apps/reconstruct/colmap_program.h"
#include "apps/reconstruct/colmap_stages.h"
#include "apps/reconstruct/film_frames.h"
#include "tests/splatting/io/test_images.h"
#include "tests/support/test_files.h"

namespace vesta::app {
namespace {

using testing::ElementsAre;

TEST(FramesOfAFilm, AreThreePerSecondWithinLimits) {
  struct Case {
    double seconds, rate;
    std::optional<int> wanted;
    int photographs, candidates;
  };
  for (const auto& [seconds, rate, wanted, photographs, candidates] : std::vector<Case>{
           {60, 30, {}, 180, 540},
           {600, 30, {}, 300, 900},
           {5, 30, {}, 40, 120},
           {5, 10, {}, 40, 50},  // a film with few frames
           {10, 1, {}, 10, 10},
           {60, 30, 25, 25, 75},
           {1, 30, 10000, 30, 30},
           {0.01, 30, {}, 1, 1},
       }) {
    const FramePlan plan = PlanFrames(seconds, rate, wanted);
    EXPECT_EQ(plan.photographs, photographs) << seconds;
    EXPECT_EQ(plan.candidates, candidates) << seconds;
    EXPECT_NEAR(plan.rate, candidates / seconds, 1e-9);
  }
}

TEST(PairsOfPhotographs, DependOnTheirNumber) {
  EXPECT_EQ(ChoosePairs(false, 300, 0), Pairs::kAll);
  EXPECT_EQ(ChoosePairs(false, 300, 300), Pairs::kAll);
  EXPECT_EQ(ChoosePairs(true, 40, 0), Pairs::kNeighbours);
  EXPECT_EQ(ChoosePairs(false, 301, 1), Pairs::kNeighbours);
  EXPECT_EQ(ChoosePairs(false, 301, 2), Pairs::kAndPositions);
}

class CameraGroups : public testing::Test {
 protected:
  void Write(const std::string& name, const std::string& bytes) {
    WriteBytes(folder_ / name, bytes);
    names_.push_back(name);
  }
  GroupedPhotographs Group() const { return GroupByCamera(folder_.path(), names_); }

  TempFolder folder_;
  std::vector<std::string> names_;
};

TEST_F(CameraGroups, SizeModelAndFocalLength) {
  const std::string jpeg = gs::ExampleJpeg(6, 4), upright = gs::ExampleJpeg(4, 6);
  Write("a.jpg", gs::WithCamera(jpeg, "Phone", 26, true));
  Write("b.jpg", gs::WithCamera(jpeg, "Phone", 52, true));
  Write("c.jpg", gs::WithCamera(jpeg, "Phone", 26, false));
  Write("d.jpg", gs::WithCamera(upright, "Phone", 26, true));
  Write("e.jpg", jpeg);
  Write("f.png", gs::EncodePng({6, 4, 2, 8, false, std::vector<std::uint8_t>(72, 9)}));
  const GroupedPhotographs grouped = Group();
  std::vector<std::vector<std::string>> names;
  for (const CameraGroup& group : grouped.groups) {
    names.push_back(group.names);
    EXPECT_TRUE(group.is_one_camera);
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre(ElementsAre("a.jpg", "c.jpg"), ElementsAre("b.jpg"),
                                                   ElementsAre("d.jpg"), ElementsAre("e.jpg", "f.png")));
  EXPECT_EQ(grouped.num_positions, 3u);
}

TEST_F(CameraGroups, OfTooManyCamerasColmapDecides) {
  for (int i = 0; i < 20; ++i) Write(fmt::format("{:02}.jpg", i), gs::ExampleJpeg(6 + i, 4));
  EXPECT_EQ(Group().groups.size(), 20u);
  Write("20.jpg", gs::ExampleJpeg(60, 4));
  const GroupedPhotographs grouped = Group();
  ASSERT_EQ(grouped.groups.size(), 1u);
  EXPECT_FALSE(grouped.groups[0].is_one_camera);
  EXPECT_EQ(grouped.groups[0].names, names_);
}

TEST_F(CameraGroups, ModelForTheNumberOfPhotographs) {
  for (int i = 0; i < 9; ++i) Write(fmt::format("{}.jpg", i), gs::ExampleJpeg(6, 4));
  EXPECT_STREQ(Group().groups[0].model, "SIMPLE_RADIAL");
  Write("9.jpg", gs::ExampleJpeg(6, 4));
  EXPECT_STREQ(Group().groups[0].model, "OPENCV");
}

TEST(LogCounter, CountsLinesOrTakesTheNumberInParentheses) {
  const LogCounter files{.texts = {"Processed file ["}, .changed = {}};
  EXPECT_EQ(CountAfter("Processed file [1/9]\nother\nProcessed file [2/9]\n", files, 3), 5u);
  const LogCounter registered{.texts = {"Registering image #"}, .is_numbered = true, .changed = {}};
  EXPECT_EQ(CountAfter("Registering image #7 (3)\nRegistering image #12 (4)\n (99)\n", registered, 2), 3u);
  EXPECT_EQ(CountAfter("Registering image #7 (3)\n", registered, 40), 40u) << "another model";
  EXPECT_EQ(CountAfter("Registering image #12 (num_reg_frames=5)\n", registered, 4), 5u) << "later versions";
  EXPECT_EQ(CountAfter("Registering image #12\nother (6)\n", registered, 4), 4u);
}

}  // namespace
}  // namespace vesta::app
