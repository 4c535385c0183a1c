// Bundle adjustment on a GPU: all observations through the one formula of the projection, the Jacobian in the memory of
// the device, conjugate gradients on cameras and points together with their diagonal blocks as the preconditioner.
#pragma once

#include <memory>

#include "problems/bundle_adjustment/bundle_data.h"
#include "solver/device_block_problem.h"
#include "solver/lm_options.h"

namespace vesta::bundle {

// x as in BundleProblem: the cameras, nine parameters each, then the points. Plain least squares.
std::unique_ptr<DeviceBlockProblem<double>> MakeDeviceBundleProblem(const BundleData& data);

// BundleLmOptions for it: nothing is eliminated.
LmOptions DeviceBundleLmOptions();

}  // namespace vesta::bundle
