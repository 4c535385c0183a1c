// SPDX-License-Identifier: Apache-2.0
// The image of a view in the memory of a GPU as a function of its camera's pose and lens: the products of
// pose_jacobian.h and lens_jacobian.h. Those that return a cotangent wait for the device.
#pragma once

#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "kernels/gaussian_splatting/projection/camera_kernels.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"

namespace vesta::splat {

void ApplyPoseJ(const DeviceSplatView& view, const Model<float>& model, const PoseTangent& xi, float* d_image,
                DeviceViewWorkspace& workspace);
PoseTangent PoseCotangent(const DeviceSplatView& view, const Model<float>& model,
                          const SplatTangent<float>* cotangents);
void ApplyLensJ(const DeviceSplatView& view, const LensTangent& delta, float* d_image, DeviceViewWorkspace& workspace);
// As pose_jacobian.h has it.
void ApplyModelAndPoseJ(const DeviceSplatView& view, const Model<float>& model, const float* dx, const PoseTangent* xi,
                        float* d_image, DeviceViewWorkspace& workspace);
LensTangent LensCotangent(const DeviceSplatView& view, const SplatTangent<float>* cotangents);

}  // namespace vesta::splat
