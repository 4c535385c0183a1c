// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/colmap_files.h"

#include <algorithm>
#include <iterator>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

using enum CameraParameter;

const std::vector<CameraModelInfo>& Models() {
  using M = ColmapCameraModel;
  static const std::vector<CameraModelInfo> models = {
      {M::kSimplePinhole, "SIMPLE_PINHOLE", false, {kFocal, kCx, kCy}},
      {M::kPinhole, "PINHOLE", false, {kFx, kFy, kCx, kCy}},
      {M::kSimpleRadial, "SIMPLE_RADIAL", false, {kFocal, kCx, kCy, kK1}},
      {M::kRadial, "RADIAL", false, {kFocal, kCx, kCy, kK1, kK2}},
      {M::kOpenCv, "OPENCV", false, {kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2}},
      {M::kOpenCvFisheye, "OPENCV_FISHEYE", true, {kFx, kFy, kCx, kCy, kK1, kK2, kK3, kK4}},
      {M::kFullOpenCv, "FULL_OPENCV", false, {kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kK4, kK5, kK6}},
      {M::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", true, {kFocal, kCx, kCy, kK1}},
      {M::kRadialFisheye, "RADIAL_FISHEYE", true, {kFocal, kCx, kCy, kK1, kK2}},
  };
  return models;
}

template <class Is>
const CameraModelInfo* FindWhere(const Is& is) {
  const auto found = std::find_if(Models().begin(), Models().end(), is);
  return found == Models().end() ? nullptr : &*found;
}

}  // namespace

const CameraModelInfo* FindCameraModel(std::int32_t number) {
  return FindWhere([&](const CameraModelInfo& info) { return static_cast<std::int32_t>(info.model) == number; });
}

const CameraModelInfo* FindCameraModel(std::string_view name) {
  return FindWhere([&](const CameraModelInfo& info) { return info.name == name; });
}

const CameraModelInfo& InfoOf(ColmapCameraModel model) {
  const CameraModelInfo* info = FindCameraModel(static_cast<std::int32_t>(model));
  VESTA_CHECK(info != nullptr, "no camera model has the number {}", static_cast<std::int32_t>(model));
  return *info;
}

std::string CameraModelName(std::int32_t number) {
  constexpr std::int32_t kFov = 7, kThinPrism = 10;
  if (number == kFov) return "FOV";
  if (number == kThinPrism) return "THIN_PRISM_FISHEYE";
  const CameraModelInfo* info = FindCameraModel(number);
  return info ? info->name : std::to_string(number);
}

double& ParameterOf(ColmapCamera& record, CameraParameter parameter) {
  splat::Lens& lens = record.camera.lens;
  switch (parameter) {
    case kFocal:
    case kFx:
      return lens.fx;
    case kFy:
      return lens.fy;
    case kCx:
      return lens.cx;
    case kCy:
      return lens.cy;
    case kP1:
      return record.distortion.tangential[0];
    case kP2:
      return record.distortion.tangential[1];
    default:
      return record.distortion.radial.at(static_cast<std::size_t>(parameter) - static_cast<std::size_t>(kK1));
  }
}

const char* WhatIs(CameraParameter parameter) {
  switch (parameter) {
    case kFocal:
    case kFx:
    case kFy:
      return "the camera's focal length";
    case kCx:
    case kCy:
      return "the camera's principal point";
    default:
      return "the camera's distortion";
  }
}

}  // namespace vesta::gs
