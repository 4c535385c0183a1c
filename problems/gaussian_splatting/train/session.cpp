#include "problems/gaussian_splatting/train/session.h"

#include "problems/gaussian_splatting/train/length_units.h"

namespace vesta::gs {

std::vector<splat::PinholeView> TrainingPinholes(const TrainingSession& session) {
  const double near = NearPlane(session.scene());
  std::vector<splat::PinholeView> pinholes;
  for (const View* view : session.training_views()) pinholes.push_back(ToPinhole(*view, near));
  return pinholes;
}

std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model) {
  return LengthUnits(model, TrainingPinholes(session), session.scene().extent);
}

}  // namespace vesta::gs
