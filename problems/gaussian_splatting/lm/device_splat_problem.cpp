#include "problems/gaussian_splatting/lm/device_splat_problem.h"

#include <numeric>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/lm/device_metric.h"
#include "problems/gaussian_splatting/lm/device_splat_linearization.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"

namespace vesta::gs {
namespace {

std::vector<splat::PinholeView> Pinholes(const std::vector<TargetView<CudaBackend<float>>>& views) {
  std::vector<splat::PinholeView> pinholes;
  pinholes.reserve(views.size());
  for (const TargetView<CudaBackend<float>>& view : views) pinholes.push_back(view.pinhole);
  return pinholes;
}

}  // namespace

std::vector<TargetView<CudaBackend<float>>> UploadTargets(const std::vector<TargetView<CpuBackend<float>>>& views) {
  std::vector<TargetView<CudaBackend<float>>> targets;
  targets.reserve(views.size());
  for (const TargetView<CpuBackend<float>>& view : views) {
    VESTA_CHECK(view.truth.size() == 3 * Index{view.pinhole.width} * view.pinhole.height,
                "a truth image of {} values for a view of {} x {}", view.truth.size(), view.pinhole.width,
                view.pinhole.height);
    targets.push_back({view.pinhole, {}});
    targets.back().truth.CopyFrom(view.truth);
  }
  return targets;
}

DeviceSplatProblem::DeviceSplatProblem(const SplatProblemOptions& options,
                                       const std::vector<TargetView<CudaBackend<float>>>& views)
    : options_(options),
      views_(views),
      batches_(options.batches, Pinholes(views)),
      loss_(std::make_shared<DevicePhotometricLoss>(options.weights)),
      workspace_(std::make_shared<splat::DeviceViewWorkspace>()) {
  CheckSampling(options);
  CheckUnits(options);
  if (options.units) {
    units_.CopyFrom(HostSpan<const float>(options.units->data(), static_cast<Index>(options.units->size())));
  }
}

Index DeviceSplatProblem::num_parameters() const { return splat::NumAttributes(options_.sh_degree) * options_.count; }

double DeviceSplatProblem::Cost(ConstView x) {
  std::vector<Index> all(views_.size());
  std::iota(all.begin(), all.end(), Index{0});
  return Cost(x, all);
}

double DeviceSplatProblem::Cost(ConstView x, std::span<const Index> units) {
  const splat::Model<float> model{x.data(), options_.count, options_.sh_degree, options_.sh_degree};
  double cost = 0;
  for (const Index unit : units) {
    const TargetView<CudaBackend<float>>& target = views_[static_cast<std::size_t>(unit)];
    cost_view_.Build(model, target.pinhole, options_.background.data(), *workspace_);
    cost_image_.ResizeForOverwrite(target.truth.size());
    cost_view_.Render(cost_image_.data());
    cost += loss_->Evaluate(cost_image_, target.truth, target.shape()).cost;
  }
  return cost;
}

std::unique_ptr<Linearization<CudaBackend<float>>> DeviceSplatProblem::Linearize(ConstView x, int batch) {
  std::vector<DeviceBatchView> views;
  for (const Index v : batches_.views(batch)) views.push_back({&views_[static_cast<std::size_t>(v)], v});
  return std::make_unique<DeviceSplatLinearization>(options_, x, views, batches_.scale(), turn_, loss_, workspace_);
}

void DeviceSplatProblem::BeginTurn(int turn) {
  turn_ = turn;
  batches_.BeginTurn(turn);
}

bool DeviceSplatProblem::DampingMetric(ConstView x, ConstView diag_h, View D) {
  if (options_.rates_damping <= 0) return false;
  B backend;
  const Index n = options_.count;
  if (ones_.size() != n) {
    ones_.ResizeForOverwrite(n);
    backend.Fill(1, ones_);
  }
  const double sum = backend.Dot(diag_h.subspan(splat::kOpacity * n, n), ones_.view());
  const std::vector<double> metric = RatesMetric(options_, sum);
  for (std::size_t a = 0; a < metric.size(); ++a) {
    backend.Fill(metric[a], D.subspan(static_cast<Index>(a) * n, n));
  }
  if (metric.empty()) return false;
  device_metric::Complete(
      {static_cast<float>(options_.rotation_damping), n, units_.empty() ? nullptr : units_.data(), x.data(), D.data()});
  return true;
}

bool DeviceSplatProblem::LimitStep(ConstView x, View step) {
  if (options_.step_limit.kind == StepLimitKind::kNone) return false;
  HostBuffer<float> host_x(x.size()), host_step(step.size());
  B backend;
  backend.ToHost(x, host_x);
  backend.ToHost(step, host_step);
  if (!gs::LimitStep<float>(options_.step_limit, options_.count, options_.sh_degree, host_x, host_step)) return false;
  backend.FromHost(host_step, step);
  return true;
}

}  // namespace vesta::gs
