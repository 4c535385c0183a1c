// SPDX-License-Identifier: Apache-2.0
// COLMAP sparse models, binary and text. Format: COLMAP's documentation, "Output Format".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/points/random_points.h"

namespace vesta::gs {

// The supported models, with COLMAP's numbers.
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
  Camera camera;               // fx == fy if the model has one focal length
  Distortion distortion = {};  // zeros for coefficients that the model lacks
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
  // ColmapImage::id of the images that see the point; empty unless requested.
  std::vector<std::uint32_t> seen_by = {};
};

// 2D points are skipped on reading, and left empty on writing, like ColmapPoint::seen_by.
struct ColmapModel {
  std::vector<ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
  Index stated_images = 0;    // the number of images that the header of images.txt states; 0 without a header
  Index unusable_points = 0;  // points that are not finite, or too large for float; they are left out
};

enum class ColmapFormat { kBinary, kText };

// Reads cameras, images and points3D of the folder: .bin, or .txt if there is no cameras.bin. Throws Error, with the
// file, the byte (or line) and what to do, unless all of this holds: sizes and focal lengths are positive and finite;
// distortion and poses are finite; quaternions are not zero; image names and camera ids are unique; the cameras
// of all images exist; there is at least one image. For an unsupported camera model (FOV, THIN_PRISM_FISHEYE), the
// message has the colmap command that undistorts the images. tracks: read ColmapPoint::seen_by.
ColmapModel ReadColmapModel(const std::string& folder, bool tracks = false);

// Creates the folder and writes the three files, each completely or not at all. Both formats preserve numbers exactly.
void WriteColmapModel(const ColmapModel& model, const std::string& folder, ColmapFormat format);

// SCENE/sparse/0 or SCENE/sparse; empty if neither exists.
std::string FindColmapModel(const std::string& scene_folder);

// Reads the COLMAP model of a scene folder. The views are sorted by name, every 8th is a test view (SortAndSplit), and
// their images are not loaded. Image files are in SCENE/image_folder. A model without points gets random points
// (PointsForCameras) and a note.
Scene ReadColmapScene(const std::string& scene_folder, const std::string& image_folder,
                      const RandomPoints& random = {});

// Per point of a scene: View::id of the views that are known to see it.
using PointTracks = std::vector<std::vector<std::uint32_t>>;
// Reads the tracks of a scene that was loaded from this folder. Empty if the folder has no COLMAP model, if the model
// has no tracks, or if the scene has other points. Throws Error like ReadColmapModel.
PointTracks ReadTracks(const std::string& scene_folder, const Scene& scene);

// views: the views of the scene with the cameras to store, in the coordinates of the scene. The model is in the
// coordinates of the scene's files (Scene::origin). Equal cameras are stored once. If LoadScene has undistorted a
// photograph, its original camera, with distortion, is stored.
ColmapModel ColmapOf(const Scene& scene, const std::vector<View>& views);

}  // namespace vesta::gs
