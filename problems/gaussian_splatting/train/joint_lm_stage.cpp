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

JointOptions OptionsOf(const TrainingSession& session, int done, bool eliminate_views) {
  const TrainOptions& options = session.options();
  return {.free = FreeBy(options.cameras.refine),
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

std::vector<ViewUnknowns> UnknownsOf(const JointLayout& layout, const LmStepper<B>& stepper) {
  std::vector<ViewUnknowns> views;
  for (Index v = 0; v < layout.views; ++v) views.push_back(layout.UnknownsOf(stepper.x(), v));
  return views;
}

}  // namespace

std::string RunJointLmStage(TrainingSession& session, SplatModel& model, bool eliminate_views) {
  TrainingCameras& cameras = session.cameras();
  LmStart start(session, model);
  const JointOptions options = OptionsOf(session, start.shape.done, eliminate_views);
  // What was found is from there, with photographs as they are.
  const std::vector<const View*>& given = cameras.given();
  std::vector<std::shared_ptr<const Image>> photographs;  // out of the store
  const std::vector<TargetView<B>> targets = MakeTargets<B>(
      given, options.near, OwnTrainingViews(session.ranks(), static_cast<Index>(given.size())), &photographs);
  JointProblem<float> problem(ProblemOptionsOf(options, model, start.shape.units), targets);
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
