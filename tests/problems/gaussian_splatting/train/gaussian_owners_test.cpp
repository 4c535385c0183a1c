#include "problems/gaussian_splatting/train/gaussian_owners.h"

#include <gtest/gtest.h>

namespace vesta::gs {
namespace {

TEST(GaussianOwners, HaveAboutAsManyNumbersEach) {
  // The first fifth with harmonics: 13 chunks, some 375 numbers a Gaussian there and 230 elsewhere.
  const splat::ModelLayout layout = splat::LayoutOfBands({13 * kTurnChunk - 100, 600, 600, 600});
  const GaussianOwners owners(layout, 3);
  Index end = 0;
  for (int r = 0; r < 3; ++r) {
    const GaussianRange own = owners.Of(r);
    EXPECT_EQ(own.begin, end) << "each Gaussian is somebody's";
    EXPECT_EQ(own.begin % kTurnChunk, 0);
    EXPECT_EQ(owners.BlocksOf(r).begin * term::kLanes, own.begin);
    end = own.end;
  }
  EXPECT_EQ(end, layout.count);
  EXPECT_LE(owners.ChunksOf(0).size(), owners.ChunksOf(1).size());
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(static_cast<double>(owners.ChunksOf(r).size()), 13 / 3.0, 1);
}

TEST(GaussianOwners, MayBeMoreThanThereIsToOwn) {
  const GaussianOwners owners({.count = 300}, 5);
  Index gaussians = 0, with_any = 0;
  for (int r = 0; r < 5; ++r) {
    const GaussianRange own = owners.Of(r);
    EXPECT_LE(own.begin, own.end);
    EXPECT_EQ(owners.BlocksOf(r).size(), (own.end - own.begin + term::kLanes - 1) / term::kLanes);
    gaussians += own.end - own.begin, with_any += own.end > own.begin ? 1 : 0;
  }
  EXPECT_EQ(gaussians, 300);
  EXPECT_EQ(with_any, 2);
}

}  // namespace
}  // namespace vesta::gs
