#include "problems/gaussian_splatting/train/session.h"

#include "problems/gaussian_splatting/model/length_units.h"

namespace vesta::gs {

std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model) {
  const Scene& scene = session.scene();
  return LengthUnits(model, session.training_views(), NearPlane(scene), scene.extent);
}

std::vector<TargetView<CpuBackend<float>>> TargetsOf(const std::vector<const View*>& views, double near) {
  std::vector<TargetView<CpuBackend<float>>> targets;
  targets.reserve(views.size());
  for (const View* view : views) {
    targets.push_back({ToPinhole(*view, near), {view->image.rgb.data(), static_cast<Index>(view->image.rgb.size())}});
  }
  return targets;
}

}  // namespace vesta::gs
