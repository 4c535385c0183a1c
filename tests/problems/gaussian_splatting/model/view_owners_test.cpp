#include "problems/gaussian_splatting/model/view_owners.h"

#include <gtest/gtest.h>

namespace vesta::gs {
namespace {

TEST(ViewOwners, HaveEachTrainingViewOnceInOrder) {
  for (const Index views : {1, 7, 64, 100, 302}) {
    for (const int processes : {1, 2, 3, 5, 64, 70}) {
      Index next = 0;
      for (int process = 0; process < processes; ++process) {
        const Share own = ViewsOfProcess(views, processes, process);
        EXPECT_EQ(own.begin, next) << views << " views, process " << process << " of " << processes;
        next = own.end;
      }
      EXPECT_EQ(next, views);
    }
  }
}

// What a process trains on by Adam is what it has of LM's parts.
TEST(ViewOwners, RunsMakeUpWhatAProcessHas) {
  constexpr Index kViews = 100;
  for (int process = 0; process < 3; ++process) {
    const Share runs = ShareOf(ViewRunsOf(kViews), 3, process), own = ViewsOfProcess(kViews, 3, process);
    EXPECT_EQ(ViewsOfRun(kViews, static_cast<int>(runs.begin)).begin, own.begin);
    EXPECT_EQ(ViewsOfRun(kViews, static_cast<int>(runs.end) - 1).end, own.end);
  }
}

TEST(ViewOwners, TheFirstHasWhatIsNotTrainedOn) {
  std::vector<View> views(5);
  views[0].role = ViewRole::kTest;
  views[3].role = ViewRole::kHeldOut;
  EXPECT_EQ(OwnViewsOf(views, 2, 0), (std::vector<bool>{true, true, false, true, false}));
  EXPECT_EQ(OwnViewsOf(views, 2, 1), (std::vector<bool>{false, false, true, false, true}));
  EXPECT_EQ(OwnViewsOf(views, nullptr), std::vector<bool>(5, true));
}

}  // namespace
}  // namespace vesta::gs
