// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/device_bundle.h"

#include <utility>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "problems/bundle_adjustment/device_residuals.h"
#include "problems/bundle_adjustment/observation.h"
#include "problems/bundle_adjustment/structure.h"

namespace vesta::bundle {

std::unique_ptr<DeviceBlockProblem<double>> MakeDeviceBundleProblem(const BundleData& data) {
  const Structure checked(data);  // throws if the data are inconsistent
  ObservationBlocks blocks(data);
  return std::make_unique<DeviceBlockProblem<double>>(blocks.num_parameters, MakeDeviceResiduals(blocks.functors),
                                                      blocks.index, std::move(blocks.groups));
}

LmOptions DeviceBundleLmOptions() {
  LmOptions options = BundleLmOptions();
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  return options;
}

}  // namespace vesta::bundle
