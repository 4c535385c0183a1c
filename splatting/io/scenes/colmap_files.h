// The pieces that the two COLMAP formats share. Internal to the reader.
#pragma once

#include <string>

#include "splatting/io/scenes/colmap.h"

namespace vesta::gs {

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
