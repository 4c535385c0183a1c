// SPDX-License-Identifier: Apache-2.0
// COLMAP sparse models, binary and text, read and written. Format: COLMAP's documentation, "Output Format".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/random_points.h"

namespace vesta::gs {

// Those of COLMAP's models that are read, by its numbers.
enum class ColmapCameraModel : std::int32_t {
  kSimplePinhole = 0,
  kPinhole = 1,
  kSimpleRadial = 2,
  kRadial = 3,
  kOpenCv = 4,
  kOpenCvFisheye = 5,
  kFullOpenCv = 6,
  kSimpleRadialFisheye = 8,
  kRadialFisheye = 9,
};

struct ColmapCamera {
  std::uint32_t id = 0;
  ColmapCameraModel model = ColmapCameraModel::kPinhole;
  Camera camera;               // fx == fy where the model has one focal length
  Distortion distortion = {};  // zeros where the model has no such coefficient
};

struct ColmapImage {
  std::uint32_t id = 0;
  std::array<double, 4> rotation{1, 0, 0, 0};  // quaternion w x y z, world to camera
  std::array<double, 3> translation{};
  std::uint32_t camera_id = 0;
  std::string name;
};

struct ColmapPoint {
  std::uint64_t id = 0;
  std::array<double, 3> position{};
  std::array<std::uint8_t, 3> color{};
  double error = 0;  // mean reprojection error in pixels
};

// The image observations of points (2-D points and tracks) are skipped when reading and left empty when writing.
struct ColmapModel {
  std::vector<ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
};

enum class ColmapFormat { kBinary, kText };

// Reads cameras, images and points3D (.bin, or .txt where there is no cameras.bin) of the folder. Everything returned
// is checked: positive finite sizes and focal lengths, finite distortion, poses and points, quaternions not zero,
// unique image names and camera ids, known camera ids, at least one image. Otherwise throws Error, one
// line with the file, the byte (or line) and what to do; for a camera model that is not read (FOV, THIN_PRISM_FISHEYE)
// that is the colmap command that undistorts.
ColmapModel ReadColmapModel(const std::string& folder);

// Writes the three files, each whole or not at all, creating the folder. Numbers survive exactly in both formats.
void WriteColmapModel(const ColmapModel& model, const std::string& folder, ColmapFormat format);

// The folder with the model of a scene: SCENE/sparse/0 or SCENE/sparse; empty where there is neither.
std::string FindColmapModel(const std::string& scene_folder);

// Views with normalised rotations, sorted and split, without pixels; image files lie in SCENE/image_folder. Of a model
// without points those of PointsInViews, and a note.
Scene ReadColmapScene(const std::string& scene_folder, const std::string& image_folder,
                      const RandomPoints& random = {});

// The scene as a COLMAP model. views: of the scene, wherever their cameras stand now, in the scene's frame. The model
// is in the world of the scene's files, with its points; one camera for each different one, of photographs that were
// undistorted that of their files.
ColmapModel ColmapOf(const Scene& scene, const std::vector<View>& views);

}  // namespace vesta::gs
