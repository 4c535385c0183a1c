// What the LM stage goes on from, beside options and photographs: the model, its units of length, and the solve.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// What stands before the saved solve (LmStepper::Save), which begins with the model's parameters.
struct LmStageShape {
  int sh_degree = 0;
  Index count = 0;
  int done = 0;              // iterations of solves before this one
  std::vector<float> units;  // of length, as they were when the stage began

  template <class Archive>
  void Visit(Archive& archive) {
    archive(sh_degree, count, done, units);
  }
};

// The model in what such a stage saved.
inline SplatModel ModelOfLmStage(const std::string& saved) {
  ArchiveReader reader(saved);
  LmStageShape shape;
  SplatModel model;
  reader(shape, model.data);
  model.sh_degree = shape.sh_degree;
  model.count = shape.count;
  const auto size = static_cast<Index>(model.data.size());
  VESTA_CHECK(model.sh_degree >= 0 && model.sh_degree <= 3 && model.count >= 0 && model.count <= size &&
                  size == model.num_attributes() * model.count,
              "a saved model of {} parameters for {} Gaussians", model.data.size(), model.count);
  return model;
}

}  // namespace vesta::gs
