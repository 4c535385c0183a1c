#include "problems/gaussian_splatting/train/joint_lm_stage.h"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/cameras/joint_parts.h"
#include "problems/gaussian_splatting/cameras/refine_jointly.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/lm_steps.h"
#include "solver/distributed/distributed_problem.h"

namespace vesta::gs {
namespace {

using B = CpuBackend<float>;

// Radial distortion is free where a photograph is of a lens that bends.
FreeUnknowns FreeIn(const TrainingSession& session) {
  FreeUnknowns free = FreeBy(session.options().cameras.refine);
  for (const View* view : session.cameras().given()) {
    free.radial = free.radial || FreeBy(session.options().cameras.refine, *view).radial;
  }
  return free;
}

JointOptions OptionsOf(const TrainingSession& session, int done, bool eliminate_views) {
  const TrainOptions& options = session.options();
  return {.free = FreeIn(session),
          .iterations = options.lm.iterations - done,
          .lm = options.lm,
          .rates = options.rates,
          .background = options.background,
          .near = NearPlane(session.scene()),
          .extent = session.scene().extent,
          .eliminate_views = eliminate_views};
}

// Spread over processes, where there are any.
class SharedProblem {
 public:
  SharedProblem(Ranks* ranks, JointProblem<float>& problem) : problem_(problem), parts_(problem) {
    if (ranks) distributed_.emplace(*ranks, parts_);
  }
  Problem<B>& operator*() { return distributed_ ? static_cast<Problem<B>&>(*distributed_) : problem_; }

 private:
  JointProblem<float>& problem_;
  JointParts<float> parts_;
  std::optional<DistributedProblem<B>> distributed_;
};

LmStepper<B> MakeStepper(const vesta::LmOptions& engine, B& backend, Problem<B>& problem, const JointLayout& layout,
                         LmStart& start, const SplatModel& model, const std::vector<ViewUnknowns>& found) {
  if (start.saved()) return {engine, backend, problem, start.solve()};
  return {engine, backend, problem, JointStart(layout, model, found)};
}

// What photographs of views are unbent by, by what has been found.
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

// Photographs of lenses that bend, unbent, for as long as the stage looks at them: those of the session are made anew
// as lenses are found.
class UnbentPhotographs {
 public:
  // by: of each view; empty: none is unbent. targets: of own views point to them then.
  UnbentPhotographs(const std::vector<const View*>& given, const Share& own, const std::vector<RadialCoefficients>& by,
                    std::vector<TargetView<B>>& targets) {
    for (Index v = own.begin; v < own.end && !by.empty(); ++v) {
      const auto at = static_cast<std::size_t>(v);
      if (!given[at]->bent) continue;
      const Image& image =
          *images_.emplace_back(std::make_unique<Image>(Unbent(*given[at]->Photograph(), given[at]->camera, by[at])));
      targets[at].truth = SplatBackend<B>::MakeTruth(ValuesOf(image));
      targets[at].mask = SplatBackend<B>::MakeMask(MaskOf(image));
    }
  }

 private:
  std::vector<std::unique_ptr<const Image>> images_;
};

std::vector<ViewUnknowns> UnknownsOf(const JointLayout& layout, const LmStepper<B>& stepper) {
  std::vector<ViewUnknowns> views;
  for (Index v = 0; v < layout.views; ++v) views.push_back(layout.UnknownsOf(stepper.x(), v));
  return views;
}

}  // namespace

std::string RunJointLmStage(TrainingSession& session, SplatModel& model, bool eliminate_views) {
  TrainingCameras& cameras = session.cameras();
  LmStart start(session, model);
  if (!start.saved()) start.shape.eliminates_views = eliminate_views;
  const JointOptions options = OptionsOf(session, start.shape.done, start.shape.eliminates_views);
  // What was found is from there, with photographs as they are, but for what they are unbent by.
  const std::vector<const View*>& given = cameras.given();
  const Share own = OwnTrainingViews(session.ranks(), static_cast<Index>(given.size()));
  std::vector<std::shared_ptr<const Image>> photographs;  // out of the store
  std::vector<TargetView<B>> targets = MakeTargets<B>(given, options.near, own, &photographs);
  if (options.free.radial && !start.saved()) start.shape.unbent_by = BendsFound(cameras);
  if (start.saved() && !AreBendsOf(given, options.free, start.shape.unbent_by)) session.RefuseSavedStage();
  const UnbentPhotographs unbent(given, own, start.shape.unbent_by, targets);
  JointProblem<float> problem(ProblemOptionsOf(options, model, start.shape.units, given, start.shape.unbent_by),
                              targets);
  const JointLayout& layout = problem.layout();
  SharedProblem shared(session.ranks(), problem);
  B backend;
  LmStepper<B> stepper = MakeStepper(EngineOptionsOf(options), backend, *shared, layout, start, model, cameras.found());
  if (start.saved() && !cameras.Restore(UnknownsOf(layout, stepper))) session.RefuseSavedStage();
  model.data = std::vector<float>();  // until the stepper is done its x begins with the model
  const auto best = [&] { return BestOf(stepper, model); };
  const auto take_cameras = [&] {
    const std::vector<ViewUnknowns> found = UnknownsOf(layout, stepper);
    for (std::size_t v = 0; v < found.size(); ++v) cameras.Set(v, found[v]);
    cameras.DevelopAll();
  };
  const auto evaluate = [&] { return session.Evaluate(best()); };
  std::string report = RunLmSteps(session, stepper, start.shape, {model.count, evaluate, best}, take_cameras);
  model.data.assign(stepper.x().begin(), stepper.x().begin() + layout.splats);
  return report;
}

}  // namespace vesta::gs
