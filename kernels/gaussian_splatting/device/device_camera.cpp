// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/device/device_camera.h"

#include "kernels/gaussian_splatting/device/device_passes.h"

namespace vesta::splat {

void ApplyPoseJ(const DeviceSplatView& view, const Model<float>& model, const PoseTangent& xi, float* d_image,
                DeviceViewWorkspace& workspace) {
  device_passes::PoseTangents(model, view.camera(), view.rank_of().data(), xi,
                              view.SplatTangents(workspace.splat_sums));
  view.ApplyRasterJ(workspace.splat_sums.data(), d_image);
}

PoseTangent PoseCotangent(const DeviceSplatView& view, const Model<float>& model,
                          const SplatTangent<float>* cotangents) {
  return device_passes::PoseCotangent(model, view.camera(), view.rank_of().data(), cotangents);
}

void ApplyLensJ(const DeviceSplatView& view, const LensTangent& delta, float* d_image, DeviceViewWorkspace& workspace) {
  device_passes::LensTangents(view.splats().data(), view.num_splats(), view.camera(), delta,
                              view.SplatTangents(workspace.splat_sums));
  view.ApplyRasterJ(workspace.splat_sums.data(), d_image);
}

void ApplyModelAndPoseJ(const DeviceSplatView& view, const Model<float>& model, const float* dx, const PoseTangent* xi,
                        float* d_image, DeviceViewWorkspace& workspace) {
  const PosedCamera& camera = view.camera();
  SplatTangent<float>* const sum = view.SplatTangents(workspace.splat_sums);
  device_passes::ProjectTangent(model, camera, view.rank_of().data(), dx, sum);
  if (xi) {
    SplatTangent<float>* const moved = view.SplatTangents(workspace.pair_sums);
    device_passes::PoseTangents(model, camera, view.rank_of().data(), *xi, moved);
    device_passes::AddTangents(moved, view.num_splats(), sum);
  }
  view.ApplyRasterJ(sum, d_image);
}

LensTangent LensCotangent(const DeviceSplatView& view, const SplatTangent<float>* cotangents) {
  return device_passes::LensCotangent(view.splats().data(), view.num_splats(), view.camera(), cotangents);
}

}  // namespace vesta::splat
