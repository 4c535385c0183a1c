// Of processes that train together, which looks at the photographs of which views.
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

// The training views are cut into runs of consecutive ones, as many whatever the number of processes: the order of sums
// goes by them. A process has a run of these runs, of which some may be empty where there are more processes.
inline int ViewRunsOf(Index views) {
  constexpr Index kMost = 64;
  return static_cast<int>(std::clamp<Index>(views, 1, kMost));
}
inline Share ViewsOfRun(Index views, int run) { return ShareOf(views, ViewRunsOf(views), run); }
// The training views of a process.
inline Share ViewsOfProcess(Index views, int processes, int process) {
  const int runs = ViewRunsOf(views);
  const Share own = ShareOf(runs, processes, process);
  return {ShareOf(views, runs, static_cast<int>(own.begin)).begin,
          ShareOf(views, runs, static_cast<int>(own.end)).begin};
}
inline Share OwnTrainingViews(const Ranks* ranks, Index views) {
  return ranks ? ViewsOfProcess(views, ranks->size(), ranks->rank()) : Share{0, views};
}

// Of each view of a scene whether it falls to the process; those that are not trained on fall to the first.
inline std::vector<bool> OwnViewsOf(const std::vector<View>& views, int processes, int process) {
  const Share own = ViewsOfProcess(NumTrainingViews(views), processes, process);
  std::vector<bool> is_own;
  is_own.reserve(views.size());
  Index place = 0;  // among the training views
  for (const View& view : views) {
    is_own.push_back(view.is_trained() ? place >= own.begin && place < own.end : process == 0);
    if (view.is_trained()) ++place;
  }
  return is_own;
}
inline std::vector<bool> OwnViewsOf(const std::vector<View>& views, const Ranks* ranks) {
  return OwnViewsOf(views, ranks ? ranks->size() : 1, ranks ? ranks->rank() : 0);
}

}  // namespace vesta::gs
