// SPDX-License-Identifier: Apache-2.0
// device_math.h with the host as the device.
#include "tests/cuda/device_math.h"

namespace vesta::splat {

bool HasDevice() { return true; }

template <class S>
const char* EvaluateAllOnDevice(const CameraConstants<S, Pinhole<S>>& camera, const S* x, const S* dx, S* out) {
  EvaluateAll(camera, x, dx, out);
  return nullptr;
}

template const char* EvaluateAllOnDevice<float>(const CameraConstants<float, Pinhole<float>>&, const float*,
                                                const float*, float*);
template const char* EvaluateAllOnDevice<double>(const CameraConstants<double, Pinhole<double>>&, const double*,
                                                 const double*, double*);

}  // namespace vesta::splat
