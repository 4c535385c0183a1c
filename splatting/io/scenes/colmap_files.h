// SPDX-License-Identifier: Apache-2.0
// Camera models and checks that COLMAP's two formats share. Internal to the reader.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/gaussian_splatting/lenses/models.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::gs {

// Parameters of COLMAP's camera models, in the same order in both formats. Source: COLMAP, src/colmap/sensor/models.h.
enum class CameraParameter { kFocal, kFx, kFy, kCx, kCy, kK1, kK2, kK3, kK4, kK5, kK6, kP1, kP2 };

struct CameraModelInfo {
  ColmapCameraModel model;
  const char* name;
  bool is_fisheye;
  std::vector<CameraParameter> parameters;
};

// Null if the model is not supported.
const CameraModelInfo* FindCameraModel(std::int32_t number);
const CameraModelInfo* FindCameraModel(std::string_view name);
// The model must be supported.
const CameraModelInfo& InfoOf(ColmapCameraModel model);

// A camera model's name for messages, for example "SIMPLE_RADIAL", also of an unsupported model. If COLMAP's
// documentation does not name the model, its number.
std::string CameraModelName(std::int32_t number);

// Sets the camera's model. Sets each parameter to read(description), in the order of the file. description: text for
// messages (WhatIs).
template <class Read>
void ReadParameters(const CameraModelInfo& info, const Read& read, ColmapCamera* record);
// Calls write(value) for each parameter, in the order of the file.
template <class Write>
void WriteParameters(const ColmapCamera& record, const Write& write);

// The member that stores a parameter; fx for kFocal.
double& ParameterOf(ColmapCamera& record, CameraParameter parameter);
// For messages, such as "the camera's focal length".
const char* WhatIs(CameraParameter parameter);

template <class Read>
void ReadParameters(const CameraModelInfo& info, const Read& read, ColmapCamera* record) {
  record->model = info.model;
  record->distortion.is_fisheye = info.is_fisheye;
  record->camera.lens.model = std::max(0, splat::IndexOf(splat::LensModels(), info.name));
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

ColmapModel ReadColmapBinary(const std::string& folder, bool tracks);
ColmapModel ReadColmapText(const std::string& folder, bool tracks);
void WriteColmapBinary(const ColmapModel& model, const std::string& folder);
void WriteColmapText(const ColmapModel& model, const std::string& folder);

// Throw Error if the record is invalid. where: "FILE: byte N" or "FILE: line N".
void CheckColmapCamera(const ColmapCamera& camera, const std::string& where);
void CheckColmapImage(const ColmapImage& image, const std::string& where);

// Throws Error for a camera model. The message has the command that undistorts the images.
[[noreturn]] void FailCameraModel(const std::string& folder, const std::string& where, const std::string& model);

}  // namespace vesta::gs
