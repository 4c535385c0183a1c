#include "bench/cameras/endings.h"

#include <algorithm>
#include <ctime>
#include <memory>
#include <utility>

#include "bench/cameras/perturbed_scene.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/cameras/align_view.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"
#include "problems/gaussian_splatting/lm/engine_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {
namespace {

using B = CpuBackend<float>;

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The views where they stand, with their photographs.
std::vector<gs::View> Standing(const std::vector<const gs::View*>& given, const std::vector<gs::ViewUnknowns>& start) {
  std::vector<gs::View> views;
  for (std::size_t v = 0; v < given.size(); ++v) {
    views.push_back(gs::MovedView(*given[v], start.empty() ? splat::CameraMotion{} : start[v].motion));
    views.back().image = given[v]->image;
  }
  return views;
}

void AlignAll(const gs::SplatModel& model, const gs::JointOptions& options, std::vector<gs::View>* views) {
  gs::AlignOptions align;
  align.free = options.free;
  align.background = options.background;
  align.near = options.near;
  align.weights = gs::LossOf(options.lm);
  for (gs::View& view : *views) {
    const splat::CameraMotion motion = gs::AlignView(model, view, align).found.motion;
    splat::MovePose(motion, view.rotation.data(), view.translation.data());
  }
}

// The splats alone by LM, as RefineJointly takes steps of both; lambda goes on from turn to turn.
LmSummary RefineSplats(const gs::JointOptions& options, const std::vector<gs::View>& views, int iterations,
                       double* lambda, gs::SplatModel* model) {
  std::vector<const gs::View*> pointers;
  pointers.reserve(views.size());
  for (const gs::View& view : views) pointers.push_back(&view);
  gs::SplatProblemOptions problem_options = gs::SplatProblemOptionsOf(options.lm, *model);
  problem_options.background = options.background;
  problem_options.rates = options.rates;
  problem_options.units =
      std::make_shared<const std::vector<float>>(gs::LengthUnits(*model, pointers, options.near, options.extent));
  const std::vector<gs::TargetView<B>> targets = gs::MakeTargets<B>(pointers, options.near);
  gs::SplatProblem<B> problem(problem_options, targets);
  LmOptions engine = gs::LmEngineOptions(options.lm);
  engine.max_iterations = iterations;
  engine.batch_mode = BatchMode::kExact;
  engine.line_search.enabled = false;
  if (*lambda > 0) engine.step_control.initial_lambda = *lambda;
  HostBuffer<float> x(static_cast<Index>(model->data.size()));
  std::copy(model->data.begin(), model->data.end(), x.begin());
  B backend;
  LmSummary summary = SolveLm<B>(engine, backend, problem, x);
  std::copy(x.begin(), x.end(), model->data.begin());
  *lambda = summary.iterations.back().lambda;
  return summary;
}

void AlignOrAlternate(bool alternates, const std::vector<const gs::View*>& given,
                      const std::vector<gs::ViewUnknowns>& start, const EndingOptions& options, Ended* ended) {
  VESTA_CHECK(!options.joint.free.color, "exposures are found by the joint endings only");
  const int rounds = alternates ? options.rounds : 1;
  std::vector<gs::View> views = Standing(given, start);
  double lambda = 0;
  for (int round = 0; round < rounds; ++round) {
    AlignAll(ended->model, options.joint, &views);
    if (!alternates) break;
    const int done = options.joint.iterations * round / rounds, to = options.joint.iterations * (round + 1) / rounds;
    const LmSummary summary = RefineSplats(options.joint, views, to - done, &lambda, &ended->model);
    ended->products += summary.num_products;
    ended->report += summary.FullReport();
  }
  for (std::size_t v = 0; v < views.size(); ++v) ended->views.push_back({gs::MotionBetween(*given[v], views[v]), {}});
}

}  // namespace

Ending TakeEnding(std::string* method) {
  const std::size_t plus = method->find('+');
  if (plus == std::string::npos) return Ending::kLm;
  const std::string name = method->substr(plus + 1);
  method->resize(plus);
  constexpr std::pair<const char*, Ending> kEndings[] = {{"lm", Ending::kLm},       {"nothing", Ending::kNothing},
                                                         {"align", Ending::kAlign}, {"alternate", Ending::kAlternate},
                                                         {"joint", Ending::kJoint}, {"reduced", Ending::kReduced}};
  for (const auto& [known, ending] : kEndings) {
    if (name == known) return ending;
  }
  throw Error("+" + name + ": what follows is lm, nothing, align, alternate, joint or reduced");
}

Ended RunEnding(Ending ending, gs::SplatModel model, const std::vector<const gs::View*>& given,
                const std::vector<gs::ViewUnknowns>& start, const EndingOptions& options) {
  const double begin = CpuSeconds();
  Ended ended;
  if (ending == Ending::kJoint || ending == Ending::kReduced) {
    gs::JointOptions joint = options.joint;
    joint.eliminate_views = ending == Ending::kReduced;
    gs::JointRefinement refined = gs::RefineJointly(std::move(model), given, start, joint);
    ended.model = std::move(refined.model);
    ended.views = std::move(refined.views);
    ended.products = refined.summary.num_products;
    ended.report = refined.summary.FullReport();
  } else {
    ended.model = std::move(model);
    AlignOrAlternate(ending == Ending::kAlternate, given, start, options, &ended);
  }
  ended.seconds = CpuSeconds() - begin;
  return ended;
}

}  // namespace vesta::bench
