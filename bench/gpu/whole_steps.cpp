// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/whole_steps.h"

#include <chrono>

#include "kernels/core/device_kernels.h"
#include "kernels/core/device_sort.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "solver/levenberg_marquardt.h"
#include "splatting/adam/device_adam_steps.h"
#include "splatting/train/adam_stage/trained_model.h"

namespace vesta::bench {
namespace {

using Gpu = CudaBackend<float>;

std::vector<gs::TargetView<Gpu>> TargetsOf(const Workload& workload) {
  std::vector<gs::TargetView<CpuBackend<float>>> targets;
  for (std::size_t v = 0; v < workload.views.size(); ++v) {
    const std::vector<float>& truth = workload.photographs[v];
    targets.push_back({workload.views[v], {truth.data(), static_cast<Index>(truth.size())}});
  }
  return gs::TargetsIn<Gpu>(targets);
}

// Cost of one call of body(), divided by `parts`.
template <class Body>
StepCost CostOf(int parts, const Body& body) {
  device::Synchronize();
  const device::HostWork before = device::CountedHostWork();
  const auto begin = std::chrono::steady_clock::now();
  body();
  const device::HostWork after = device::CountedHostWork();
  device::Synchronize();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return {seconds / parts, static_cast<double>(after.launches - before.launches) / parts,
          static_cast<double>(after.waits - before.waits) / parts,
          static_cast<double>(device::PeakBytes()) / (1 << 30)};
}

}  // namespace

StepCost AdamIterationCost(const Workload& workload, int repeats) {
  device::ResetPeak();
  const std::vector<gs::TargetView<Gpu>> targets = TargetsOf(workload);
  const int degree = workload.model.sh_degree, attributes = splat::NumAttributes(degree);
  gs::TrainedModel<Gpu> trained(workload.model, gs::Adam<Gpu>(gs::LearningRates(), gs::SecondMoment::kBlock),
                                gs::DensityControl<Device>(gs::DensityOptions(), workload.extent), workload.views,
                                workload.extent);
  DevicePhotometricLoss loss{PhotometricWeights{.l1_floor = 0}};
  splat::DeviceSplatView view;
  splat::DeviceViewWorkspace workspace;
  DeviceBuffer<float> image, image_gradient;
  const double background[3] = {0, 0, 0};
  std::size_t next = 0;
  const auto iterate = [&] {
    const gs::TargetView<Gpu>& target = targets[next++ % targets.size()];
    const ImageShape shape = target.shape();
    const splat::Model<float> x = trained.kernel_model(degree);
    image.ResizeForOverwrite(shape.NumValues());
    image_gradient.ResizeForOverwrite(shape.NumValues());
    view.Build(x, target.camera, background, workspace);
    view.Render(image.data());
    loss.Gradient(image, target.truth, shape, image_gradient);
    view.AddJT(x, image.data(), image_gradient.data(), trained.gradient(attributes), workspace);
    trained.density().Observe({view.rank_of().data(), view.splats().data(), workspace.splat_sums.data(), 1.0f});
    static_cast<void>(loss.Value());
    trained.Step(attributes, 1);
  };
  for (int warm_up = 0; warm_up < 3; ++warm_up) iterate();
  return CostOf(repeats, [&] {
    for (int i = 0; i < repeats; ++i) iterate();
  });
}

StepCost LmIterationCost(const Workload& workload) {
  device::ResetPeak();
  const std::vector<gs::TargetView<Gpu>> targets = TargetsOf(workload);
  DeviceBuffer<float> x;
  x.CopyFrom(HostSpan<const float>(workload.model.data.data(), static_cast<Index>(workload.model.data.size())));
  gs::SplatProblemOptions options;
  options.count = workload.model.count;
  options.sh_degree = workload.model.sh_degree;
  options.gradient_shrinkage = 0;
  gs::SplatProblem<Gpu> problem(options, targets);
  LmOptions engine;
  engine.max_iterations = 2;
  engine.function_tolerance = engine.gradient_tolerance = engine.parameter_tolerance = 0;
  engine.column_scaling = ColumnScaling::kNone;
  engine.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  engine.normal_system.pcg.max_iterations = 8;
  engine.normal_system.pcg.model_tolerance = 0;
  Gpu backend;
  LmStepper<Gpu> stepper(engine, backend, problem, x.view());
  return CostOf(1, [&] { stepper.Step(); });
}

}  // namespace vesta::bench
