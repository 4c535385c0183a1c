// SPDX-License-Identifier: Apache-2.0
// Least-squares problems on a GPU with many residual blocks, all with the same number of residuals and parameters. The
// Jacobian is stored in device memory.
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/cuda_backend.h"
#include "kernels/core/row_blocks.h"
#include "solver/problem_interfaces.h"

namespace vesta {

// Computes the residuals of a problem on the device. solver/device_functors.cuh implements it for functors.
template <class S>
class DeviceResiduals {
 public:
  virtual ~DeviceResiduals() = default;
  virtual Index num_residual_blocks() const = 0;
  virtual int residuals_per_block() const = 0;
  virtual int parameters_per_block() const = 0;
  // Computes the residuals at x and, unless jacobian is null, the Jacobian. There are N = num_residual_blocks() blocks
  // with P = parameters_per_block() parameters each. Column c of block b belongs to parameter index[c * N + b].
  // Residual k of block b is residuals[k * N + b], and its derivatives are jacobian[(k * P + c) * N + b] (RowBlocks in
  // kernels/core/row_blocks.h). All pointers are to device memory. The call is asynchronous.
  virtual void Evaluate(const Index* index, const S* x, S* residuals, S* jacobian) const = 0;
};

// S is float or double.
template <class S>
class DeviceBlockProblem final : public Problem<CudaBackend<S>> {
 public:
  using B = CudaBackend<S>;
  using typename Problem<B>::ConstVectorView;
  using typename Problem<B>::VectorView;

  // index: the parameters of each residual block, with the layout of DeviceResiduals::Evaluate. groups: parameter
  // blocks for block Jacobi; empty for none. A residual block that uses any parameter of a parameter block must use all
  // of them, in order, as adjacent columns. Throws Error if a size or an index is wrong.
  DeviceBlockProblem(Index num_parameters, std::unique_ptr<DeviceResiduals<S>> residuals,
                     const std::vector<Index>& index, std::vector<BlockGroup> groups = {});
  ~DeviceBlockProblem() override;

  Index num_parameters() const override;
  double Cost(ConstVectorView x) override;
  // The problem must outlive the result.
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;

 private:
  struct Data;
  class Linear;
  std::unique_ptr<Data> data_;
};

}  // namespace vesta
