// SPDX-License-Identifier: Apache-2.0
// A scene: images, their cameras and poses, and points for the initial Gaussians.
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

// A pinhole camera without its pose. Pixel (i, j) covers [i, i + 1) x [j, j + 1); its centre is at (i + 0.5, j + 0.5).
struct Camera {
  int width = 0, height = 0;  // image size, pixels
  splat::Lens lens;
  // 2D dilation: variance added to both axes of a projected Gaussian, in pixels squared at any image size; the same for
  // all cameras of a scene (LoadSceneOptions). A splat must be rendered with the value of its training.
  double eps2d = splat::kEps2d;
  // Whether opacities are compensated for the dilation (SplatShape in project.h). As for eps2d, the same for all
  // cameras, and rendered as trained.
  bool antialiased = false;

  double pixels() const { return ImageSize{width, height}.pixels(); }
  bool operator==(const Camera&) const = default;
};

// The camera for the image resized to width x height pixels.
Camera ResizeCamera(const Camera& camera, int width, int height);

// The camera for another image size: the image is scaled with equal factors until it covers the size, then cropped
// around its centre.
Camera CropCamera(const Camera& camera, ImageSize size);

// A camera with lens distortion.
struct LensCamera {
  Camera camera;  // without the distortion
  Distortion distortion;

  bool operator==(const LensCamera&) const = default;
};

enum class ViewRole {
  kTraining,
  kHeldOut,  // not used for training steps; measures quality during the training, for example to end it
  kTest,     // not used for training or its decisions; measures quality only
};

// One image with its pose. Camera axes: x right, y down, z forward (COLMAP); x_camera = rotation x_world + translation.
struct View {
  std::uint32_t id = 0;    // of the image in a COLMAP model; 0 in other scenes
  std::string name;        // relative to the image folder; views are sorted and split by it (SortAndSplit)
  std::string image_path;  // path of the image file
  std::string mask_path;   // empty: no mask, or only the alpha channel of the photograph
  Camera camera;
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major, orthonormal, world to camera
  std::array<double, 3> translation{};
  ViewRole role = ViewRole::kTraining;
  Image image;  // of the camera's size; empty before loading and if `stored` is used
  // Used instead of `image` if the photographs do not fit into memory, else null.
  std::shared_ptr<const StoredPhotograph> stored;
  Distortion distortion;  // of the photograph; none after LoadScene has undistorted it
  // Camera in the file, if LoadScene has undistorted the photograph.
  std::optional<LensCamera> bent;

  bool is_trained() const { return role == ViewRole::kTraining; }
  bool is_test() const { return role == ViewRole::kTest; }
  // From `image`: valid while the view exists. From `stored`: valid while the result exists. Throws Error if the file
  // can no longer be read.
  std::shared_ptr<const Image> Photograph() const;
};

// A copy of the view with the photograph in `image`.
View HoldingPhotograph(const View& view);

// In world coordinates.
std::array<double, 3> CameraCenter(const View& view);

std::array<double, 3> InCamera(const View& view, const std::array<double, 3>& point);

// Depth of a world point if it is in front of the camera and inside the image; otherwise 0.
double DepthInView(const View& view, const std::array<float, 3>& point);

struct PointCloud {
  std::vector<std::array<float, 3>> positions;  // finite, world coordinates
  std::vector<std::array<float, 3>> colors;     // r, g, b in 0..1; one per position
  Index size() const { return static_cast<Index>(positions.size()); }
};

// The origin may differ from the files' (model/scene_frame.h).
struct Scene {
  std::vector<View> views;  // sorted by name
  PointCloud points;
  double extent = 1;               // see SceneExtent
  std::array<double, 3> origin{};  // origin of the scene's frame, in the coordinates of the files
  std::vector<std::string> files;  // input files besides the images
  // What chose the test views, for messages: a list in the scene, a flag, or the rule of SortAndSplit.
  std::string split = "every 8th";
  std::vector<std::string> notes;  // one line each for the user, for example about ignored input
  std::string points_note;         // the one of the notes about random points, if any
  // Null if the images are in the views.
  std::shared_ptr<PhotographStore> photographs;
};

// In the order of `views`.
std::vector<const View*> TrainingViews(const std::vector<View>& views);
Index NumTrainingViews(const std::vector<View>& views);
// Fraction of the pixels of all these views that masks include. Photographs that are not in memory count as unmasked.
double UnmaskedFraction(const std::vector<const View*>& views);
inline Index NumTrainingViews(const Scene& scene) { return NumTrainingViews(scene.views); }

// Sorts by name and marks every 8th view, starting with the first, as a test view.
void SortAndSplit(std::vector<View>* views);
// Marks every N-th of the sorted views, N = `every`, as a test view, starting with the first; 0: none. All others
// become training views. Throws Error for every < 0.
void SplitByCount(int every, std::vector<View>* views);
// Holds out every 8th training view, starting with the fourth, but at least one. Throws Error if no training view would
// remain.
void HoldOut(std::vector<View>* views);

// Unit of length of the training: half the median depth of the points that are visible in the training images. So a
// learning rate for positions means about the same motion in pixels for any arrangement of cameras. If no point is
// visible, the unit is 1.1 times the largest distance of a camera from the mean camera centre, as in Kerbl et al. 2023
// (after NeRF++); 1 if all camera centres coincide too.
double SceneExtent(const std::vector<View>& views, const PointCloud& points);

// For an even number of values, the larger of the two in the middle. `values` must not be empty.
template <class T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Camera centres: their mean, and the largest distance from it, in world units.
struct CameraSpread {
  std::array<double, 3> mean{};
  double radius = 0;
};
CameraSpread SpreadOf(const std::vector<const View*>& views);

// Sum of the images' unit up vectors, in world coordinates; near 0 if there is no common up.
std::array<double, 3> SumOfUps(const std::vector<View>& views);

// Horizontal field of view, degrees.
double HorizontalAngle(const Camera& camera);

}  // namespace vesta::gs
