// Stage two: Levenberg-Marquardt on all training views, by the engine.
#include <fmt/format.h>

#include <algorithm>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/train/session.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::gs {
namespace {

SplatProblemOptions ProblemOptions(const TrainingSession& session, const SplatModel& model, int views) {
  const TrainOptions& options = session.options();
  SplatProblemOptions result;
  result.sh_degree = model.sh_degree;
  result.count = model.count;
  result.background = options.background;
  result.weights.l1_floor = options.lm.l1_floor;
  result.num_batches = std::min(options.lm.batches, views);
  result.rates_damping = options.lm.damping == "rates" ? options.lm.rates_damping : 0;
  result.rates = options.rates;
  result.extent = session.scene().extent;
  return result;
}

StepRule StepRuleOf(const std::string& name) {
  if (name == "ceres") return StepRule::kCeres;
  if (name == "nielsen") return StepRule::kNielsen;
  if (name == "v1") return StepRule::k3dgsLmV1;
  if (name == "v2") return StepRule::k3dgsLmV2;
  if (name == "code") return StepRule::k3dgsLmCode;
  return StepRule::kSoft;
}

vesta::LmOptions EngineOptions(const LmOptions& lm) {
  vesta::LmOptions engine;
  engine.max_iterations = lm.iterations;
  engine.function_tolerance = 0;
  engine.gradient_tolerance = 0;
  engine.parameter_tolerance = 0;
  engine.SetStepRule(StepRuleOf(lm.step_control));
  engine.step_control.initial_lambda = lm.initial_lambda;
  engine.step_control.min_lambda = lm.min_lambda;
  engine.step_control.max_lambda = lm.max_lambda;
  engine.column_scaling = ColumnScaling::kNone;
  engine.normal_system.metric.group_median_floor = 1e-6;
  engine.normal_system.preconditioner =
      lm.preconditioner == "block" ? PreconditionerKind::kBlockJacobi : PreconditionerKind::kJacobi;
  engine.normal_system.pcg.max_iterations = lm.pcg_iterations;
  engine.batch_mode = lm.merge_batches ? BatchMode::kMerge : BatchMode::kExact;
  engine.line_search.enabled = lm.line_search;
  engine.line_search.unit_fraction = lm.line_search_views;
  return engine;
}

}  // namespace

std::string RunLmStage(TrainingSession& session, SplatModel& model) {
  const LmOptions& lm = session.options().lm;
  const double near = NearPlane(session.scene());
  std::vector<TargetView<float>> targets;
  double values = 0;
  for (const View* view : session.training_views()) {
    targets.push_back({ToPinhole(*view, near), {view->image.rgb.data(), static_cast<Index>(view->image.rgb.size())}});
    values += static_cast<double>(view->image.rgb.size());
  }
  const int views = static_cast<int>(targets.size());
  SplatProblem<float> problem(ProblemOptions(session, model, views), std::move(targets));
  CpuBackend<float> backend;
  LmStepper<CpuBackend<float>> stepper(EngineOptions(lm), backend, problem,
                                       {model.data.data(), static_cast<Index>(model.data.size())});
  session.Record(Stage::kLm, 0, ToKernelModel(model));
  while (!stepper.done() && !session.ShouldStop()) {
    const LmIteration& row = stepper.Step();
    std::copy(stepper.x().begin(), stepper.x().end(), model.data.begin());
    session.Record(Stage::kLm, row.iteration, ToKernelModel(model));
    session.Report({Stage::kLm, row.iteration, lm.iterations, session.Seconds(), row.cost / values,
                    session.latest_psnr(), model.count,
                    fmt::format("lambda {:.1e} rho {:.2f} gamma {:.2f} pcg {}{}", row.lambda, row.rho, row.gamma,
                                row.pcg_iterations, row.accepted ? "" : " rejected")});
  }
  return stepper.summary().FullReport();
}

}  // namespace vesta::gs
