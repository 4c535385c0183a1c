// SPDX-License-Identifier: Apache-2.0
// A toy problem and a bundle adjustment reach the same minima on the GPU as on the host.
#include "bench/collections/generate_bundle.h"
#include "kernels/core/cuda_backend.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "problems/bundle_adjustment/device_bundle.h"
#include "problems/toy/device_toy.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/cuda/on_device.h"

namespace vesta {
namespace {

using test::ToDevice;
using test::ToHost;

class CudaEngine : public test::OnDevice {};

LmOptions Tight() {
  LmOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  return options;
}

TEST_F(CudaEngine, ACurveFitReachesTheMinimumOfTheHost) {
  const std::vector<ExponentialFit> samples = ExponentialSamples(200);
  ResidualBlocks<ExponentialFit, CpuBackend<double>> host(2, samples);
  CpuBackend<double> cpu;
  std::vector<double> x(2, 0.0);
  const LmSummary expected = SolveLm<CpuBackend<double>>(Tight(), cpu, host, {x.data(), 2});

  std::vector<Index> index(2 * samples.size(), 0);
  std::fill(index.begin() + static_cast<std::ptrdiff_t>(samples.size()), index.end(), 1);
  DeviceBlockProblem<double> problem(2, MakeDeviceResiduals(samples), index);
  // Solvers that need no support by the problem.
  for (const LinearSolverKind kind : {LinearSolverKind::kPcg, LinearSolverKind::kLsmr, LinearSolverKind::kDenseQr}) {
    SCOPED_TRACE(ToString(kind));
    LmOptions options = Tight();
    options.normal_system.linear_solver = kind;
    options.normal_system.pcg.model_tolerance = 1e-10;
    CudaBackend<double> gpu;
    DeviceBuffer<double> at(2);
    const LmSummary found = SolveLm<CudaBackend<double>>(options, gpu, problem, at.view());
    EXPECT_NEAR(found.final_cost, expected.final_cost, 1e-8 * expected.final_cost) << found.message;
    const std::vector<double> result = ToHost(at);
    EXPECT_NEAR(result[0], x[0], 1e-6);
    EXPECT_NEAR(result[1], x[1], 1e-6);
  }
}

TEST_F(CudaEngine, ABundleAdjustmentReachesTheMinimumOfTheHost) {
  const bundle::BundleData data = bundle::Generate({.num_cameras = 10, .num_points = 200, .mean_track = 4, .seed = 1});
  bundle::BundleProblem host(data);
  CpuBackend<double> cpu;
  std::vector<double> x = data.x;
  LmOptions host_options = bundle::BundleLmOptions();
  host_options.max_iterations = 100;
  host_options.function_tolerance = 1e-12;
  const LmSummary expected =
      SolveLm<CpuBackend<double>>(host_options, cpu, host, {x.data(), static_cast<Index>(x.size())});

  const auto problem = bundle::MakeDeviceBundleProblem(data);
  CudaBackend<double> gpu;
  DeviceBuffer<double> at = ToDevice(data.x);
  EXPECT_NEAR(problem->Cost(at), expected.initial_cost, 1e-10 * expected.initial_cost);
  LmOptions options = bundle::DeviceBundleLmOptions();
  options.max_iterations = host_options.max_iterations;
  options.function_tolerance = host_options.function_tolerance;
  const LmSummary found = SolveLm<CudaBackend<double>>(options, gpu, *problem, at.view());
  EXPECT_NEAR(found.final_cost, expected.final_cost, 1e-6 * expected.final_cost) << found.message;
}

}  // namespace
}  // namespace vesta
