// SPDX-License-Identifier: Apache-2.0
// The pieces that COLMAP's two formats share, and its camera models. Internal to the reader.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/gaussian_splatting/lenses/models.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::gs {

// What the parameters of COLMAP's camera models are, in their order in both formats. Source: COLMAP,
// src/colmap/sensor/models.h. Internal to the reader.
enum class CameraParameter { kFocal, kFx, kFy, kCx, kCy, kK1, kK2, kK3, kK4, kK5, kK6, kP1, kP2 };

struct CameraModelInfo {
  ColmapCameraModel model;
  const char* name;
  bool is_fisheye;
  std::vector<CameraParameter> parameters;
};

// Null where the model is not read.
const CameraModelInfo* FindCameraModel(std::int32_t number);
const CameraModelInfo* FindCameraModel(std::string_view name);
// Of one that is read.
const CameraModelInfo& InfoOf(ColmapCameraModel model);

// "SIMPLE_RADIAL", also of models that are not read; the number of those that COLMAP's documentation does not name.
std::string CameraModelName(std::int32_t number);

// Gives the camera the model, and each of its parameters what read(what it is) returns, in order.
template <class Read>
void ReadParameters(const CameraModelInfo& info, const Read& read, ColmapCamera* record);
// Calls write(value) for each of them.
template <class Write>
void WriteParameters(const ColmapCamera& record, const Write& write);

// The place of a parameter; of kFocal that of fx.
double& ParameterOf(ColmapCamera& record, CameraParameter parameter);
// For messages: "the camera's focal length".
const char* WhatIs(CameraParameter parameter);

template <class Read>
void ReadParameters(const CameraModelInfo& info, const Read& read, ColmapCamera* record) {
  record->model = info.model;
  record->distortion.is_fisheye = info.is_fisheye;
  record->camera.lens.model = std::max(0, splat::PlaceOf(splat::LensModels(), info.name));
  for (const CameraParameter parameter : info.parameters) {
    ParameterOf(*record, parameter) = read(WhatIs(parameter));
    if (parameter == CameraParameter::kFocal) record->camera.lens.fy = record->camera.lens.fx;
  }
}

template <class Write>
void WriteParameters(const ColmapCamera& record, const Write& write) {
  ColmapCamera copy = record;
  for (const CameraParameter parameter : InfoOf(record.model).parameters) write(ParameterOf(copy, parameter));
}

ColmapModel ReadColmapBinary(const std::string& folder);
ColmapModel ReadColmapText(const std::string& folder);
void WriteColmapBinary(const ColmapModel& model, const std::string& folder);
void WriteColmapText(const ColmapModel& model, const std::string& folder);

// Each throws Error where the record cannot be used. `where` is the record's place, "FILE: byte N" or "FILE: line N".
void CheckColmapCamera(const ColmapCamera& camera, const std::string& where);
void CheckColmapImage(const ColmapImage& image, const std::string& where);
void CheckColmapPoint(const ColmapPoint& point, const std::string& where);

// Refuses a camera model that is not read; names the command that undistorts.
[[noreturn]] void FailCameraModel(const std::string& folder, const std::string& where, const std::string& model);

}  // namespace vesta::gs
