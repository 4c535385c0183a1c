// SPDX-License-Identifier: Apache-2.0
#include <cuda_runtime.h>

#include "tests/cuda/device_math.h"

namespace vesta::splat {
namespace {

template <class S>
struct Arguments {
  CameraConstants<S, Pinhole<S>> camera;
  S x[kGeometry], dx[kGeometry], out[kDeviceMathOutputs];
};

template <class S>
__global__ void Evaluate(Arguments<S>* arguments) {
  EvaluateAll(arguments->camera, arguments->x, arguments->dx, arguments->out);
}

}  // namespace

bool HasDevice() {
  int count = 0;
  return cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
}

template <class S>
const char* EvaluateAllOnDevice(const CameraConstants<S, Pinhole<S>>& camera, const S* x, const S* dx, S* out) {
  Arguments<S> host = {camera, {}, {}, {}};
  for (int i = 0; i < kGeometry; ++i) host.x[i] = x[i], host.dx[i] = dx[i];
  Arguments<S>* device = nullptr;
  cudaError_t status = cudaMalloc(&device, sizeof(host));
  if (status == cudaSuccess) status = cudaMemcpy(device, &host, sizeof(host), cudaMemcpyHostToDevice);
  if (status == cudaSuccess) {
    Evaluate<<<1, 1>>>(device);
    status = cudaGetLastError();
  }
  if (status == cudaSuccess) status = cudaMemcpy(&host, device, sizeof(host), cudaMemcpyDeviceToHost);
  cudaFree(device);
  for (int i = 0; i < kDeviceMathOutputs; ++i) out[i] = host.out[i];
  return status == cudaSuccess ? nullptr : cudaGetErrorString(status);
}

template const char* EvaluateAllOnDevice<float>(const CameraConstants<float, Pinhole<float>>&, const float*,
                                                const float*, float*);
template const char* EvaluateAllOnDevice<double>(const CameraConstants<double, Pinhole<double>>&, const double*,
                                                 const double*, double*);

}  // namespace vesta::splat
