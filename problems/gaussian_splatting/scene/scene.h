// SPDX-License-Identifier: Apache-2.0
// A scene: posed images, their cameras, and a point cloud for initialisation.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/lenses/lens.h"
#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/photograph_store.h"

namespace vesta::gs {

// Pixel (i, j) covers [i, i + 1) x [j, j + 1), so its centre is at (i + 0.5, j + 0.5).
struct Camera {
  int width = 0, height = 0;  // image size, pixels
  splat::Lens lens;
  // 2D dilation: variance added to both axes of a Gaussian in the image, pixels squared at any image size. All cameras
  // of a scene share it (LoadSceneOptions), and the splat must be rendered with the same value.
  double eps2d = splat::kEps2d;

  double pixels() const { return ImageSize{width, height}.pixels(); }
  bool operator==(const Camera&) const = default;
};

// The camera for its image resized to width x height.
Camera ResizeCamera(const Camera& camera, int width, int height);

// A camera with lens distortion.
struct BentCamera {
  Camera camera;  // without the distortion
  Distortion distortion;

  bool operator==(const BentCamera&) const = default;
};

// Purpose of a view.
enum class ViewRole {
  kTraining,
  kHeldOut,  // kept from training, to measure quality during training
  kTest,     // affects no decision; measures quality only
};

// One image with its pose. Camera axes: x right, y down, z forward (COLMAP); x_camera = rotation x_world + translation.
struct View {
  std::string name;        // relative to the image folder; views are sorted and split by it
  std::string image_path;  // path of the image file
  std::string mask_path;   // path of the mask file; empty: no mask, or only the alpha channel of the photograph
  Camera camera;
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major, orthonormal, world to camera
  std::array<double, 3> translation{};
  ViewRole role = ViewRole::kTraining;
  Image image;  // empty until LoadScene fills it; then of the camera's size
  // Used instead of `image` if the photographs of the scene do not fit into memory.
  std::shared_ptr<const StoredPhotograph> stored;
  Distortion distortion;  // of the photograph in its file; none after LoadScene has undistorted it
  // The camera of the photograph in the model's file, if LoadScene has undistorted the photograph.
  std::optional<BentCamera> bent;

  bool is_trained() const { return role == ViewRole::kTraining; }
  bool is_test() const { return role == ViewRole::kTest; }
  // The image, from the view or the store. It is valid while the result is held; an image in the view only while the
  // view exists. Throws Error if its file can no longer be read.
  std::shared_ptr<const Image> Photograph() const;
};

// A copy of the view with its photograph in memory.
View HoldingPhotograph(const View& view);

// Centre of the view's camera in world coordinates.
std::array<double, 3> CameraCenter(const View& view);

// A world point in camera coordinates.
std::array<double, 3> InCamera(const View& view, const std::array<double, 3>& point);

// Depth of a world point if it is in front of the camera and inside the image, otherwise 0.
double DepthInView(const View& view, const std::array<float, 3>& point);

struct PointCloud {
  std::vector<std::array<float, 3>> positions;  // finite, world coordinates
  std::vector<std::array<float, 3>> colors;     // r, g, b in 0..1; one per position
  Index size() const { return static_cast<Index>(positions.size()); }
};

// A scene. The origin of its frame may differ from the one in the files (scene_frame.h).
struct Scene {
  std::vector<View> views;  // sorted by name
  PointCloud points;
  double extent = 1;               // see SceneExtent
  std::array<double, 3> origin{};  // of this frame, in the world of the files
  std::vector<std::string> files;  // input files besides the images
  std::vector<std::string> notes;  // remarks of the loader, one line each, for example about ignored input
  // The store of photographs that do not fit into memory; null if every view holds its image.
  std::shared_ptr<PhotographStore> photographs;
};

// The training views in their order, and their number.
std::vector<const View*> TrainingViews(const std::vector<View>& views);
Index NumTrainingViews(const std::vector<View>& views);
inline Index NumTrainingViews(const Scene& scene) { return NumTrainingViews(scene.views); }

// Sorts by name and marks every 8th view, starting with the first, as a test view, as is common in the literature.
void SortAndSplit(std::vector<View>* views);
// The same split of sorted views with another interval; 0: all are training views. every >= 0.
void SplitByCount(int every, std::vector<View>* views);
// Holds out every 8th of the training views, starting with the fourth, but at least one. Throws Error if no training
// view would remain.
void HoldOut(std::vector<View>* views);

// The unit of length of the training schedule: half the median depth of the points in the training images. With it a
// learning rate for positions is a rate in pixels, for any camera arrangement. Kerbl et al. 2023 (after NeRF++) use 1.1
// times the largest distance of a camera from their mean, which is about the same for cameras all around an object.
// That is the fallback if no point is visible (1 if all centres coincide). For cameras in a row it would measure the
// length of the row, not the scene.
double SceneExtent(const std::vector<View>& views, const PointCloud& points);

// The upper median if the number is even. values must not be empty.
template <class T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Mean of the camera centres, and the largest distance from it in world units; 0 if all coincide.
struct CameraSpread {
  std::array<double, 3> mean{};
  double radius = 0;
};
CameraSpread SpreadOf(const std::vector<const View*>& views);

// Sum of the cameras' up axes in the world; near 0 if there is no common up direction.
std::array<double, 3> SumOfUps(const std::vector<View>& views);

// Horizontal field of view, degrees.
double HorizontalAngle(const Camera& camera);

}  // namespace vesta::gs
