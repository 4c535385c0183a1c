// SPDX-License-Identifier: Apache-2.0
// Which photographs share a camera, that is, focal length and distortion.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// How COLMAP models the lenses of some photographs.
struct CameraGroup {
  std::vector<std::string> names;  // sorted
  bool is_one_camera = true;       // otherwise, COLMAP shares cameras by its own rules
  const char* model = "OPENCV";    // COLMAP's name
};

struct GroupedPhotographs {
  std::vector<CameraGroup> groups;
  std::size_t num_positions = 0;  // photographs with a GPS position
};

// Photographs share a camera if their sizes and, for JPEG files, the make, model and focal lengths of their EXIF data
// are equal. Therefore upright and sideways photographs of a phone have two cameras if the phone stores rotated pixels,
// and one if it stores an orientation tag, which COLMAP ignores. With more than 20 cameras, for example of photographs
// from the web, all photographs are in one group with is_one_camera = false: one run of COLMAP per group would take too
// long.
//
// A group of 10 or more photographs has the model OPENCV, with four coefficients of distortion. Fewer photographs
// determine only one: SIMPLE_RADIAL. vesta undistorts both on loading.
//
// images: the folder; names: relative to it. Throws Error, with the file, if a file is not an image that vesta can
// train on.
GroupedPhotographs GroupByCamera(const std::string& images, const std::vector<std::string>& names);

}  // namespace vesta::app
