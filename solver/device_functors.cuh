// SPDX-License-Identifier: Apache-2.0
// DeviceResiduals for residual functors. The .cu file of a problem includes this header and defines a function that its
// C++ code calls:
//     std::unique_ptr<DeviceResiduals<double>> MakeDeviceResiduals(const std::vector<MyFunctor>& functors) {
//       return std::make_unique<FunctorsOnDevice<MyFunctor, double>>(functors);
//     }
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/launch.cuh"
#include "solver/device_block_problem.h"
#include "solver/internal/functor_call.h"

namespace vesta {

// F is a ResidualFunctor (solver/residual_blocks.h) that is trivially copyable, with operator() marked
// VESTA_HD. The functors are copied to device memory.
template <class F, class S>
class FunctorsOnDevice final : public DeviceResiduals<S> {
 public:
  explicit FunctorsOnDevice(const std::vector<F>& functors) {
    functors_.CopyFrom(HostSpan<const F>(functors.data(), static_cast<Index>(functors.size())));
  }
  Index num_residual_blocks() const override { return functors_.size(); }
  int residuals_per_block() const override { return F::kResiduals; }
  int parameters_per_block() const override { return F::kParameters; }
  void Evaluate(const Index* index, const S* x, S* residuals, S* jacobian) const override {
    device::ForEach(num_residual_blocks(),
                    EvaluateFunctor<F, S>{functors_.data(), num_residual_blocks(), index, x, residuals, jacobian},
                    "residuals");
  }

 private:
  DeviceBuffer<F> functors_;
};

}  // namespace vesta
