// What the LM stage goes on from, beside options and photographs: the model, its units of length, and the solve.
#pragma once

#include <string_view>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// What stands before the saved solve (LmStepper::Save), whose x begins with the model's parameters.
struct LmStageHeader {
  splat::ModelLayout layout;
  int done = 0;                   // iterations of solves before this one
  std::vector<float> units;       // of length, as they were when the stage began
  bool eliminates_views = false;  // where cameras are found

  template <class Archive>
  void Visit(Archive& archive) {
    archive(layout, done, units, eliminates_views);
  }
};

// The model in what such a stage saved.
inline SplatModel ModelOfLmStage(std::string_view saved) {
  ArchiveReader reader(saved);
  LmStageHeader header;
  SplatModel model;
  reader(header, model.data);
  static_cast<splat::ModelLayout&>(model) = header.layout;
  VESTA_CHECK(model.IsOfModel() && static_cast<Index>(model.data.size()) >= model.Size(),
              "a saved model of {} parameters for {} Gaussians", model.data.size(), model.count);
  model.data.resize(static_cast<std::size_t>(model.Size()));  // then come views, where LM finds them too
  return model;
}

}  // namespace vesta::gs
