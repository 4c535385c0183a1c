#include "problems/gaussian_splatting/train/session.h"

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/train/over_ranks.h"

namespace vesta::gs {

TrainingSession::TrainingSession(const Scene& scene, const TrainOptions& options, double seconds_before,
                                 const TrainCallbacks& callbacks)
    : options_(options),
      callbacks_(callbacks),
      cameras_(scene, options.cameras, OwnViewsInAdam(options, callbacks.ranks, NumTrainingViews(scene))),
      fingerprint_(FingerprintOf(scene)),
      together_(callbacks.ranks),
      clock_(seconds_before + (callbacks.resume ? callbacks.resume->run.seconds : 0),
             callbacks.resume ? callbacks.resume->run.eval_seconds : 0),
      history_(cameras_, options_, callbacks_, clock_),
      end_(options_, callbacks_, together_, clock_, history_),
      memory_(cameras_, options_, together_),
      saved_(callbacks.resume),
      interim_(callbacks_, together_, clock_, end_, notes_, [this] { return State(); }) {
  if (callbacks.resume) Resume(*callbacks.resume);
}

RunState TrainingSession::State() const {
  return {.scene = fingerprint_, .history = history_.rows(), .notes = notes_.lines(), .cameras = cameras_.found()};
}

void TrainingSession::Resume(const Checkpoint& checkpoint) {
  if (checkpoint.run.scene != fingerprint_) {
    Fail("{}: of other photographs or cameras than this scene's; give the scene that it was trained on",
         checkpoint.path);
  }
  history_.Restore(checkpoint.run.history);
  notes_.Restore(checkpoint.run.notes);
  if (!cameras_.Restore(checkpoint.run.cameras)) saved_.Refuse();
}

std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model) {
  const Scene& scene = session.scene();
  return LengthUnits(model, session.training_views(), NearPlane(scene), scene.extent);
}

}  // namespace vesta::gs
