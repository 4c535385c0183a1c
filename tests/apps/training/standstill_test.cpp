// SPDX-License-Identifier: Apache-2.0
#include "apps/training/standstill.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

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

double Unknown() { return std::numeric_limits<double>::quiet_NaN(); }

TEST(StandstillNote, NamesTheReasonsAndFlags) {
  const auto rows = Rows({18, 22, 24, 26, 27}, {17, 20, 20.5, 20.6, 20.5});
  const std::string few = StandstillNote(SceneOf(20), rows, kNone, Unknown);
  EXPECT_THAT(few, HasSubstr("20.50 dB after 200 iterations"));
  EXPECT_THAT(few, HasSubstr("24.00 to 27.00 dB"));
  EXPECT_THAT(few, HasSubstr("20 training views"));
  EXPECT_THAT(few, HasSubstr("--refine_cameras=auto"));
  const std::string many = StandstillNote(SceneOf(200), rows, kAll, Unknown);
  EXPECT_THAT(many, Not(HasSubstr("training views (")));
  EXPECT_THAT(many, Not(HasSubstr("--refine_cameras")));
}

TEST(StandstillNote, MeasuresExposures) {
  const auto rows = Rows({18, 22, 24, 26, 27}, {17, 20, 20.5, 20.6, 20.5});
  const auto with = [&](double spread) { return StandstillNote(SceneOf(20), rows, kNone, [=] { return spread; }); };
  EXPECT_THAT(StandstillNote(SceneOf(20), rows, kNone, Unknown), HasSubstr("--refine_cameras=pose+exposure"));
  EXPECT_THAT(with(0.02), Not(HasSubstr("exposures")));
  EXPECT_THAT(with(0.25), HasSubstr("(brightness by 25 %) (--refine_cameras=pose+exposure"));
}

TEST(StandstillNote, IsEmptyWhereTestViewsGain) {
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22, 24, 26, 27}, {17, 20, 20.5, 20.6, 21}), kNone, Unknown), "");
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22, 24, 24.2, 24.3}, {17, 20, 20.5, 20.6, 20.5}), kNone, Unknown),
            "");
}

TEST(StandstillNote, NeedsRowsWithTestViews) {
  EXPECT_EQ(StandstillNote(SceneOf(20), {}, kNone, Unknown), "");
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22}, {17, 17}), kNone, Unknown), "");
  EXPECT_EQ(StandstillNote(SceneOf(20), Rows({18, 22, 24, 26, 27}, {0, 0, 0, 0, 0}), kNone, Unknown), "");
}

}  // namespace
}  // namespace vesta::app
