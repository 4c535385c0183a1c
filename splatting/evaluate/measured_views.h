// Of which views a model is measured, by which process.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/distributed/process_group.h"

namespace vesta::gs {

struct MeasuredViews {
  // Of the training views as many at most, evenly spread; of the others all.
  int most_trained = std::numeric_limits<int>::max();
  ProcessGroup processes = {};  // each measures its share of the views
};

// Of each view of a scene whether it is one of them, of any process.
inline std::vector<bool> AreMeasured(const MeasuredViews& measured, const std::vector<View>& views) {
  const Index trained = NumTrainingViews(views);
  const Index most = std::min<Index>(measured.most_trained, trained);
  std::vector<bool> are_measured;
  are_measured.reserve(views.size());
  Index place = 0;  // among the training views
  for (const View& view : views) {
    // Of every run of trained / most views the last.
    are_measured.push_back(!view.is_trained() || (place + 1) * most / trained > place * most / trained);
    if (view.is_trained()) ++place;
  }
  return are_measured;
}

}  // namespace vesta::gs
