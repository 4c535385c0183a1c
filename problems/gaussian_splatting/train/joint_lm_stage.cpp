// The options of the LM stage that finds cameras, and the stage on the host.
#include "problems/gaussian_splatting/train/joint_lm_stage.h"

#include <algorithm>

namespace vesta::gs {
namespace {

// Radial distortion is free where a photograph is of a lens that bends.
FreeUnknowns FreeIn(const TrainingSession& session) {
  FreeUnknowns free = FreeBy(session.options().cameras.refine);
  for (const View* view : session.cameras().given()) {
    free.radial = free.radial || FreeBy(session.options().cameras.refine, *view).radial;
  }
  return free;
}

}  // namespace

JointOptions JointOptionsOf(const TrainingSession& session, int done, bool eliminate_views) {
  const TrainOptions& options = session.options();
  return {.free = FreeIn(session),
          .iterations = std::max(0, options.lm.iterations - done),
          .lm = options.lm,
          .rates = options.rates,
          .background = options.background,
          .near = NearPlane(session.scene()),
          .extent = session.scene().extent,
          .eliminate_views = eliminate_views};
}

std::vector<RadialCoefficients> BendsFound(const TrainingCameras& cameras) {
  std::vector<RadialCoefficients> bends;
  for (std::size_t v = 0; v < cameras.given().size(); ++v) {
    bends.push_back(Visible(cameras.given()[v]->camera, cameras.found()[v].lens.radial));
  }
  return bends;
}

bool AreBendsOf(const std::vector<const View*>& given, const FreeUnknowns& free,
                const std::vector<RadialCoefficients>& bends) {
  if (bends.size() != (free.radial ? given.size() : 0)) return false;
  for (std::size_t v = 0; v < bends.size(); ++v) {
    const LensChange bend{.radial = {bends[v][0], bends[v][1]}};
    if (!bend.is_bend_sound(CornerOf(given[v]->camera))) return false;
  }
  return true;
}

template std::string RunJointLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model,
                                                        bool eliminate_views);

}  // namespace vesta::gs
