// Stage two: Levenberg-Marquardt on all training views, by the engine.
#include <initializer_list>
#include <utility>

#include "problems/gaussian_splatting/train/lm_steps.h"

namespace vesta::gs {
namespace {

// The value that goes with a name, or `otherwise`: names are checked by ValidateOptions.
template <class T>
T ValueOf(const std::string& name, std::initializer_list<std::pair<const char*, T>> values, T otherwise) {
  for (const auto& [candidate, value] : values) {
    if (name == candidate) return value;
  }
  return otherwise;
}

PhotometricWeights LossOf(const LmOptions& lm) {
  const SsimLinearization root =
      lm.ssim_jacobian == "center" ? SsimLinearization::kRootCenter : SsimLinearization::kRoot;
  return {
      .l1 = lm.l1_weight,
      .ssim = lm.ssim_weight,
      .l1_floor = lm.l1_floor,
      .pixel = ValueOf(
          lm.loss_linearization,
          {{"sqrt", PixelLinearization::kSqrt}, {"huber", PixelLinearization::kHuber}, {"l2", PixelLinearization::kL2}},
          PixelLinearization::kIrls),
      .huber_threshold = lm.huber_threshold,
      .structure = lm.ssim_linearization == "root" ? root : SsimLinearization::kQuadratic};
}

}  // namespace

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const SplatModel& model) {
  const TrainOptions& options = session.options();
  SplatProblemOptions result;
  result.sh_degree = model.sh_degree;
  result.count = model.count;
  result.background = options.background;
  result.weights = LossOf(options.lm);
  result.batches = {
      options.lm.batches, options.lm.batch_size,
      ValueOf(options.lm.batch_choice, {{"random", BatchChoice::kRandom}, {"clustered", BatchChoice::kClustered}},
              BatchChoice::kStrided),
      options.seed};
  result.jacobian = ValueOf(
      options.lm.jacobian,
      {{"cache32", JacobianKind::kCache32}, {"cache16", JacobianKind::kCache16}, {"rebuild", JacobianKind::kRebuild}},
      JacobianKind::kRecompute);
  result.sh_blocks = options.lm.preconditioner == "block_sh";
  result.residual_sampling = options.lm.residual_sampling;
  result.sampling_unit = options.lm.sampling_unit == "tiles" ? SamplingUnit::kTiles : SamplingUnit::kRows;
  result.sample_gradient = options.lm.sample_gradient;
  result.step_limit = {
      ValueOf(options.lm.step_limit, {{"caps", StepLimitKind::kCaps}, {"hellinger", StepLimitKind::kHellinger}},
              StepLimitKind::kNone),
      options.lm.step_limit_size};
  result.seed = options.seed;
  result.position_damping = options.lm.position_damping;
  result.sh_damping = options.lm.sh_damping;
  result.view_agreement = options.lm.view_agreement;
  result.rotation_damping = options.lm.rotation_damping;
  result.rates_damping = options.lm.damping == "rates" ? options.lm.rates_damping : 0;
  result.rates = options.rates;
  result.units = std::make_shared<const std::vector<float>>(TrainingUnits(session, model));
  return result;
}

vesta::LmOptions LmEngineOptions(const LmOptions& lm) {
  vesta::LmOptions engine;
  engine.max_iterations = lm.iterations;
  engine.function_tolerance = lm.min_gain;
  engine.gradient_tolerance = 0;
  engine.parameter_tolerance = 0;
  engine.SetStepRule(ValueOf(lm.step_control,
                             {{"ceres", StepRule::kCeres},
                              {"v1", StepRule::k3dgsLmV1},
                              {"v2", StepRule::k3dgsLmV2},
                              {"code", StepRule::k3dgsLmCode}},
                             StepRule::kSoft));
  engine.step_control.initial_lambda = lm.initial_lambda;
  engine.step_control.min_lambda = lm.min_lambda;
  engine.step_control.max_lambda = lm.max_lambda;
  engine.column_scaling = ColumnScaling::kNone;
  NormalSystemOptions& system = engine.normal_system;
  system.metric.group_median_floor = lm.min_diagonal > 0 ? 0 : 1e-6;
  if (lm.min_diagonal > 0) system.metric.min_diagonal = lm.min_diagonal;
  if (lm.max_diagonal > 0) system.metric.max_diagonal = lm.max_diagonal;
  system.preconditioner =
      lm.preconditioner == "jacobi" ? PreconditionerKind::kJacobi : PreconditionerKind::kBlockJacobi;
  if (lm.preconditioner_damping != "lambda") system.preconditioner_lambda = lm.preconditioner_damping == "one" ? 1 : 0;
  system.pcg.max_iterations = lm.pcg_iterations;
  system.pcg.start = lm.pcg_start == "zero" ? PcgStart::kZero : PcgStart::kPreconditioned;
  if (lm.pcg_tolerance > 0) system.pcg.relative_tolerance = lm.pcg_tolerance, system.pcg.model_tolerance = 0;
  engine.batch_mode = lm.merge_batches ? BatchMode::kMerge : BatchMode::kExact;
  engine.line_search.enabled = lm.line_search;
  engine.line_search.unit_fraction = lm.line_search_views;
  return engine;
}

std::string RunLmStage(TrainingSession& session, SplatModel& model, bool hold_batches) {
  SplatProblem<float> problem(LmProblemOptions(session, model),
                              TargetsOf(session.training_views(), NearPlane(session.scene())));
  CpuBackend<float> backend;
  vesta::LmOptions engine = LmEngineOptions(session.options().lm);
  engine.hold_batches = hold_batches;
  HostBuffer<float> x;
  x.CopyFrom({model.data.data(), static_cast<Index>(model.data.size())});
  model.data = std::vector<float>();  // until the stepper is done its x is the model
  LmStepper<CpuBackend<float>> stepper(engine, backend, problem, std::move(x));
  const auto best = [&] { return BestOf(stepper, model); };
  std::string report =
      RunLmSteps(session, stepper, 0, {model.count, [&] { return session.Evaluate(best()); }, best}, [] {});
  model.data.assign(stepper.x().begin(), stepper.x().end());
  return report;
}

}  // namespace vesta::gs
