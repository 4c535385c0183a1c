// SPDX-License-Identifier: Apache-2.0
#include "apps/training/standstill.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vesta::app {
namespace {

using testing::HasSubstr;
using testing::Not;

// Rows of a training with the given PSNRs.
std::vector<gs::HistoryRow> Rows(const std::vector<double>& training, const std::vector<double>& test) {
  std::vector<gs::HistoryRow> rows(training.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].iteration = 100 * static_cast<int>(i);
    rows[i].train.psnr = training[i], rows[i].test.psnr = test[i];
  }
  return rows;
}

gs::Scene SceneOf(std::size_t views) {
  gs::Scene scene;
  scene.views.resize(views);
  return scene;
}

constexpr auto kNone = gs::CameraChoice::kNone, kAll = gs::CameraChoice::kAll;

TEST(StandstillNote, NamesTheReasonsAndFlags) {
  const auto rows = Rows({18, 22, 24, 26, 27}, {17, 20, 20.5, 20.6, 20.5});
  const std::string few = StandstillNote(SceneOf(20), rows, kNone);
  EXPECT_THAT(few, HasSubstr("20.50 dB after 200 iterations"));
  EXPECT_THAT(few, HasSubstr("24.00 to 27.00 dB"));
  EXPECT_THAT(few, HasSubstr("20 training views"));
  EXPECT_THAT(few, HasSubstr("--refine_cameras=auto"));
  const std::string many = StandstillNote(SceneOf(200), rows, kAll);
  EXPECT_THAT(many, Not(HasSubstr("training views (")));
  EXPECT_THAT(many, Not(HasSubstr("--refine_cameras")));
}

TEST(StandstillNote, IsEmptyWhereTestViewsGain) {
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22, 24, 26, 27}, {17, 20, 20.5, 20.6, 21}), kNone), "");
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22, 24, 24.2, 24.3}, {17, 20, 20.5, 20.6, 20.5}), kNone), "");
}

TEST(StandstillNote, NeedsRowsWithTestViews) {
  EXPECT_EQ(StandstillNote(SceneOf(20), {}, kNone), "");
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22}, {17, 17}), kNone), "");
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22, 24, 26, 27}, {0, 0, 0, 0, 0}), kNone), "");
}

}  // namespace
}  // namespace vesta::app
