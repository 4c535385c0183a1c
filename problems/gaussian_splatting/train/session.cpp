#include "problems/gaussian_splatting/train/session.h"

#include "problems/gaussian_splatting/train/length_units.h"

namespace vesta::gs {

std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model) {
  const Scene& scene = session.scene();
  return LengthUnits(model, session.training_views(), NearPlane(scene), scene.extent);
}

}  // namespace vesta::gs
