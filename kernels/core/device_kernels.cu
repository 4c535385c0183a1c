// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/device_kernels.h"
#include "kernels/core/launch.cuh"

namespace vesta::device {
namespace {

struct Nothing {
  VESTA_HD void operator()(Index) const {}
};

}  // namespace

std::string UnsupportedReason() {
  cudaFuncAttributes attributes{};
  const cudaError_t status = cudaFuncGetAttributes(&attributes, &RunForEach<Nothing>);
  if (status == cudaSuccess) return "";
  cudaGetLastError();
  return cudaGetErrorString(status);
}

}  // namespace vesta::device
