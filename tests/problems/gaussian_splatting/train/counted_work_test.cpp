#include "problems/gaussian_splatting/train/counted_work.h"

#include <gtest/gtest.h>

namespace vesta::gs {
namespace {

// Two views, one of which is too small to be halved: 40,000 and 8,000 pixels at full size, 10,000 and 8,000 coarse.
class CountedWork : public testing::Test {
 protected:
  CountedWork() {
    large_.camera.width = 200, large_.camera.height = 200;
    small_.camera.width = 100, small_.camera.height = 80;
    options_.adam.iterations = 100;
    options_.adam.coarse_part = 0.25;
  }
  double Megapixels(const std::vector<HistoryRow>& history) const {
    return CountedMegapixels({&large_, &small_}, options_, history);
  }
  static HistoryRow At(Stage stage, int iteration) {
    HistoryRow row;
    row.stage = stage, row.iteration = iteration;
    return row;
  }

  View large_, small_;
  TrainOptions options_;
};

TEST_F(CountedWork, SumsThePixelsThatAdamVisits) {
  EXPECT_NEAR(Megapixels({At(Stage::kAdam, 50), At(Stage::kAdam, 100)}), 25 * 0.009 + 75 * 0.024, 1e-12);
  EXPECT_NEAR(Megapixels({At(Stage::kAdam, 10)}), 10 * 0.009, 1e-12) << "of a training that was stopped";
  options_.adam.views_per_iteration = 3;
  options_.adam.iterations = 300;
  EXPECT_NEAR(Megapixels({At(Stage::kAdam, 100)}), 3 * (25 * 0.009 + 75 * 0.024), 1e-12);
}

TEST_F(CountedWork, CountsLmAsTheSwitchDoes) {
  const double adam = Megapixels({At(Stage::kAdam, 100)});
  EXPECT_NEAR(Megapixels({At(Stage::kAdam, 100), At(Stage::kLm, 1), At(Stage::kLm, 2)}) - adam,
              2 * LmWork(options_.lm, 2) * 0.024, 1e-12);
  EXPECT_EQ(Megapixels({At(Stage::kLm, 0)}), 0) << "a model that was only measured";
}

}  // namespace
}  // namespace vesta::gs
