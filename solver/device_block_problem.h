// SPDX-License-Identifier: Apache-2.0
// Problems of many like residual blocks on a GPU: least squares, the Jacobian kept in the memory of the device.
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/cuda_backend.h"
#include "kernels/core/row_blocks.h"
#include "solver/problem_interfaces.h"

namespace vesta {

// What a problem brings: its residuals on the device, from a functor by solver/device_functors.cuh.
template <class S>
class DeviceResiduals {
 public:
  virtual ~DeviceResiduals() = default;
  virtual Index num_residual_blocks() const = 0;
  virtual int residuals_per_block() const = 0;
  virtual int parameters_per_block() const = 0;
  // Residuals and Jacobian in the layout of RowBlocks, all in the memory of the GPU; index: as there; jacobian null:
  // not wanted. Does not wait.
  virtual void Evaluate(const Index* index, const S* x, S* residuals, S* jacobian) const = 0;
};

// S is float or double.
template <class S>
class DeviceBlockProblem final : public Problem<CudaBackend<S>> {
 public:
  using B = CudaBackend<S>;
  using typename Problem<B>::ConstVectorView;
  using typename Problem<B>::VectorView;

  // index: the parameters of each residual block, in the layout of RowBlocks. groups: for block Jacobi, as GramOfRows
  // wants them; empty: none. Throws Error where the sizes do not fit.
  DeviceBlockProblem(Index num_parameters, std::unique_ptr<DeviceResiduals<S>> residuals,
                     const std::vector<Index>& index, std::vector<BlockGroup> groups = {});
  ~DeviceBlockProblem() override;

  Index num_parameters() const override;
  double Cost(ConstVectorView x) override;
  // The problem must outlive what it returns.
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;

 private:
  struct Data;
  class Linear;
  std::unique_ptr<Data> data_;
};

}  // namespace vesta
