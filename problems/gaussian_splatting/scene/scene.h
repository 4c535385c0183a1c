// SPDX-License-Identifier: Apache-2.0
// What a scene is: posed images, their cameras, and a cloud of points to start from.
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
  int width = 0, height = 0;  // of the image, pixels
  splat::Lens lens;
  // Variance that is added to a Gaussian's two axes in the image, pixels squared of whatever size: how far a pixel
  // looks beside itself. One for all cameras of a scene (LoadSceneOptions), whose splat is to be rendered with it.
  double eps2d = splat::kEps2d;

  double pixels() const { return ImageSize{width, height}.pixels(); }
  bool operator==(const Camera&) const = default;
};

// The same camera for its image resized to width x height.
Camera ResizeCamera(const Camera& camera, int width, int height);

// A camera whose lens bends what a pinhole would show.
struct BentCamera {
  Camera camera;  // before its lens bends
  Distortion distortion;

  bool operator==(const BentCamera&) const = default;
};

// What a view is for.
enum class ViewRole {
  kTraining,
  kHeldOut,  // of those to train on, one that is kept back, to judge by while training
  kTest,     // seen by nothing that decides
};

// One image with its pose. Camera axes: x right, y down, z forward (COLMAP); x_camera = rotation x_world + translation.
struct View {
  std::string name;        // relative to the image folder; the key of order and split
  std::string image_path;  // where the file lies
  std::string mask_path;   // of its mask; empty: none, or none but the photograph's own
  Camera camera;
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major, orthonormal, world to camera
  std::array<double, 3> translation{};
  ViewRole role = ViewRole::kTraining;
  Image image;  // empty until LoadScene has filled it; then of the camera's size
  // In place of it where the photographs of the scene do not fit into memory.
  std::shared_ptr<const StoredPhotograph> stored;
  Distortion distortion;  // of the photograph as its file has it; none once LoadScene has undistorted it
  // The camera that the model has for the photograph in its file, where LoadScene has undistorted it.
  std::optional<BentCamera> bent;

  bool is_trained() const { return role == ViewRole::kTraining; }
  bool is_test() const { return role == ViewRole::kTest; }
  // The image, wherever it is; it is there while the result is held (of one in the view: while that is). Throws Error
  // where its file cannot be read any more.
  std::shared_ptr<const Image> Photograph() const;
};

// The view with its photograph in it, wherever that was.
View HoldingPhotograph(const View& view);

// Centre of the view's camera in world coordinates.
std::array<double, 3> CameraCenter(const View& view);

// A point of the world in the axes of the view's camera.
std::array<double, 3> InCamera(const View& view, const std::array<double, 3>& point);

// The depth of a point of the world in the view, where it is in front of the camera and within the image; 0 elsewhere.
double DepthInView(const View& view, const std::array<float, 3>& point);

struct PointCloud {
  std::vector<std::array<float, 3>> positions;  // finite, world coordinates
  std::vector<std::array<float, 3>> colors;     // r, g, b in 0..1; as many as positions
  Index size() const { return static_cast<Index>(positions.size()); }
};

// All in a frame whose origin may lie elsewhere than that of the files (scene_frame.h).
struct Scene {
  std::vector<View> views;  // sorted by name
  PointCloud points;
  double extent = 1;               // see SceneExtent
  std::array<double, 3> origin{};  // of this frame in the world of the files
  std::vector<std::string> files;  // that all this was read from, beside the images
  std::vector<std::string> notes;  // a line for each thing beside them that was passed over
  // Of photographs that do not fit into memory; null where all are in their views.
  std::shared_ptr<PhotographStore> photographs;
};

// Of the views those that are trained on.
// Those that are trained on, in their order; and how many.
std::vector<const View*> TrainingViews(const std::vector<View>& views);
Index NumTrainingViews(const std::vector<View>& views);
inline Index NumTrainingViews(const Scene& scene) { return NumTrainingViews(scene.views); }

// Sorts by name and marks every 8th view, from the first on, as a test view: the field's convention.
void SortAndSplit(std::vector<View>* views);
// The same split of sorted views at every so manyth; 0: all are to train on. 0 <= every.
void SplitByCount(int every, std::vector<View>* views);
// Keeps back every 8th of the training views, from the fourth on, at least one. Throws Error where that leaves none to
// train on.
void HoldOut(std::vector<View>* views);

// The unit of lengths of the training schedule: half the median depth of the points in the training views' images.
// So a learning rate for positions is one in pixels, whatever the cameras do. Kerbl et al. 2023 (after NeRF++) take 1.1
// times the largest distance of a camera from their mean, which is about the same for cameras all round an object, and
// stands in where no point is seen (1 where all centres coincide). For cameras side by side it measures the length of
// the row, not the scene.
double SceneExtent(const std::vector<View>& views, const PointCloud& points);

// The upper one of an even number. There must be one.
template <class T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The mean of their centres, and the distance of the farthest from it, world units; 0 where all coincide.
struct CameraSpread {
  std::array<double, 3> mean{};
  double radius = 0;
};
CameraSpread SpreadOf(const std::vector<const View*>& views);

// The sum of their upward axes in the world; near 0 where they share none.
std::array<double, 3> SumOfUps(const std::vector<View>& views);

// What an image shows from left to right, degrees.
double HorizontalAngle(const Camera& camera);

}  // namespace vesta::gs
