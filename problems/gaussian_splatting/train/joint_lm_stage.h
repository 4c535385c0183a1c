// Stage two where LM finds cameras, lenses and exposures too (FindsCamerasByLm): splats and views at once
// (cameras/joint_problem.h). For every memory space.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/cameras/joint_parts.h"
#include "problems/gaussian_splatting/cameras/joint_rest.h"
#include "problems/gaussian_splatting/cameras/refine_jointly.h"
#include "problems/gaussian_splatting/cameras/unbend.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/lm_model.h"
#include "problems/gaussian_splatting/train/lm_start.h"
#include "problems/gaussian_splatting/train/lm_steps.h"
#include "problems/gaussian_splatting/train/problem_to_solve.h"
#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {

// What is to be found, of a session that has done so many iterations.
JointOptions JointOptionsOf(const TrainingSession& session, int done, bool eliminate_views);
// What photographs of views are unbent by, by what has been found; and whether those that were saved are of these
// views.
std::vector<RadialCoefficients> BendsFound(const TrainingCameras& cameras);
bool AreBendsOf(const std::vector<const View*>& given, const FreeUnknowns& free,
                const std::vector<RadialCoefficients>& bends);

// Photographs of lenses that bend, unbent, for as long as the stage looks at them: those of the session are made anew
// as lenses are found.
template <class B>
class UnbentPhotographs {
 public:
  // by: of each view; empty: none is unbent. targets: of own views show them then.
  UnbentPhotographs(const std::vector<const View*>& given, const Share& own, const std::vector<RadialCoefficients>& by,
                    std::vector<TargetView<B>>& targets) {
    for (Index v = own.begin; v < own.end && !by.empty(); ++v) {
      const auto at = static_cast<std::size_t>(v);
      if (!given[at]->bent) continue;
      auto image = std::make_unique<Image>(Unbent(*given[at]->Photograph(), given[at]->camera, by[at]));
      targets[at].truth = SplatBackend<B>::MakeTruth(ValuesOf(*image));
      targets[at].mask = SplatBackend<B>::MakeMask(MaskOf(*image));
      if (std::is_same_v<typename B::Space, Host>) images_.push_back(std::move(image));  // else they are copied
    }
  }

 private:
  std::vector<std::unique_ptr<const Image>> images_;
};

// From the cameras that the session has found. eliminate_views: JointOptions has it; where the stage goes on, as it was
// when it began. Leaves model and cameras at their best and records their last state. Returns the engine's full report.
// E: as RunLmStage has it. Where the memory of a GPU does not suffice after all the stage ends with the last iteration
// that was finished; throws OutOfDeviceMemory where there was none, and no Adam stage, and of several processes. Throws
// Error for a saved state that is not of these views.
template <class B, class E = B>
std::string RunJointLmStage(TrainingSession& session, SplatModel& model, bool eliminate_views) {
  constexpr bool kOnHost = std::is_same_v<typename E::Space, Host>;
  TrainingCameras& cameras = session.cameras();
  LmStart start(session, model);
  if (!start.saved()) start.header.eliminates_views = eliminate_views;
  const JointOptions options = JointOptionsOf(session, start.header.done, start.header.eliminates_views);
  // What was found is from there, with photographs as they are, but for what they are unbent by.
  const std::vector<const View*>& given = cameras.given();
  const Share own = OwnTrainingViews(session.together().ranks(), static_cast<Index>(given.size()));
  if (options.free.radial && !start.saved()) start.header.unbent_by = BendsFound(cameras);
  if (start.saved() && !AreBendsOf(given, options.free, start.header.unbent_by)) session.saved().Refuse();
  int finished = start.finished();  // iterations, whose best model and cameras are
  try {
    std::vector<std::shared_ptr<const Image>> photographs;  // out of the store
    std::vector<TargetView<B>> targets = MakeTargets<B>(given, options.near, own, &photographs);
    const UnbentPhotographs<B> unbent(given, own, start.header.unbent_by, targets);
    JointProblem<B> problem(ProblemOptionsOf(options, model, start.header.units, given, start.header.unbent_by),
                            targets);
    const JointLayout& layout = problem.layout();
    ProblemToSolve<JointParts, B, E> solved(session.together().ranks(), problem);
    E backend;
    const vesta::LmOptions engine = EngineOptionsOf(options);
    const auto from_found = [&] {
      typename E::Vector x;
      x.CopyFrom(JointStart(layout, model, cameras.found()));
      return LmStepper<E>(engine, backend, *solved, std::move(x));
    };
    LmStepper<E> stepper = start.saved() ? start.template GoOn<LmStepper<E>>(engine, backend, *solved) : from_found();
    const auto found = [&] {
      const ConstRest<E> rest(stepper.x(), layout.splats);
      std::vector<ViewUnknowns> views;
      for (Index v = 0; v < layout.views; ++v) views.push_back(layout.UnknownsOf(rest.view(), v));
      return views;
    };
    if (start.saved() && !cameras.Restore(found())) session.saved().Refuse();
    if constexpr (kOnHost) model.data = std::vector<float>();  // until the stepper is done its x begins with the model
    LmModel<B, E> best(session, stepper, {}, problem.workspace(), model);
    std::string report = RunLmSteps(session, stepper, start.header, best.Recorded(), [&] {
      const std::vector<ViewUnknowns> views = found();
      for (std::size_t v = 0; v < views.size(); ++v) cameras.Set(v, views[v]);
      cameras.DevelopAll();
      best.AfterStep();
      ++finished;
    });
    best.TakeBest();
    return report;
  } catch (const OutOfDeviceMemory& error) {
    // The others would not know, and without an iteration or Adam nothing was done.
    const int done = start.header.done + finished;
    if (!std::is_same_v<B, E> || !session.together().is_alone() || (done == 0 && !session.options().adam.runs())) throw;
    session.Note(fmt::format("LM ends after {} iterations: {}", done, error.what()));
    return "";
  }
}

extern template std::string RunJointLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model,
                                                               bool eliminate_views);

}  // namespace vesta::gs
