// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "problems/gaussian_splatting/scene/depth_in_view.h"

namespace vesta::gs {

Camera ResizeCamera(const Camera& camera, int width, int height) {
  const double across = static_cast<double>(width) / camera.width;
  const double down = static_cast<double>(height) / camera.height;
  return {width, height, camera.lens.Scaled(across, down), camera.eps2d, camera.antialiased};
}

Camera CropCamera(const Camera& camera, ImageSize size) {
  const double across = static_cast<double>(size.width) / camera.width;
  const double down = static_cast<double>(size.height) / camera.height;
  const double scale = std::max(across, down);
  Camera cropped{size.width, size.height, camera.lens.Scaled(scale, scale), camera.eps2d, camera.antialiased};
  cropped.lens.cx += 0.5 * (size.width - scale * camera.width);
  cropped.lens.cy += 0.5 * (size.height - scale * camera.height);
  return cropped;
}

std::shared_ptr<const Image> View::Photograph() const {
  if (stored) return stored->Get();
  return {std::shared_ptr<const Image>(), &image};
}

View HoldingPhotograph(const View& view) {
  View holding = view;
  holding.stored = nullptr;
  if (view.stored) holding.image = *view.Photograph();
  return holding;
}

std::array<double, 3> CameraCenter(const View& view) {
  const auto& r = view.rotation;
  const auto& t = view.translation;
  std::array<double, 3> center;
  for (std::size_t i = 0; i < 3; ++i) center[i] = -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]);
  return center;
}

std::vector<const View*> TrainingViews(const std::vector<View>& views) {
  std::vector<const View*> trained;
  for (const View& view : views) {
    if (view.is_trained()) trained.push_back(&view);
  }
  return trained;
}

double UnmaskedFraction(const std::vector<const View*>& views) {
  double pixels = 0, unmasked = 0;
  for (const View* view : views) {
    const double all = static_cast<double>(view->camera.width) * view->camera.height;
    pixels += all, unmasked += all * UnmaskedFraction(view->image);
  }
  return pixels > 0 ? unmasked / pixels : 1;
}

Index NumTrainingViews(const std::vector<View>& views) { return std::ranges::count_if(views, &View::is_trained); }

void SortAndSplit(std::vector<View>* views) {
  std::sort(views->begin(), views->end(), [](const View& a, const View& b) { return a.name < b.name; });
  SplitByCount(8, views);
}

void SplitByCount(int every, std::vector<View>* views) {
  VESTA_CHECK(every >= 0, "the interval of test views is {}, but it must not be negative", every);
  for (std::size_t i = 0; i < views->size(); ++i) {
    const bool is_test = every > 0 && i % static_cast<std::size_t>(every) == 0;
    (*views)[i].role = is_test ? ViewRole::kTest : ViewRole::kTraining;
  }
}

void HoldOut(std::vector<View>* views) {
  std::vector<View*> trained;
  for (View& view : *views) {
    if (view.is_trained()) trained.push_back(&view);
  }
  if (trained.size() < 2)
    Fail(kBadArgument, "cannot hold out a view from {} training views: add images", trained.size());
  // The middle view of each eight; with fewer than eight the middle one.
  for (std::size_t i = std::min<std::size_t>(3, trained.size() / 2); i < trained.size(); i += 8) {
    trained[i]->role = ViewRole::kHeldOut;
  }
}

namespace {

// 1.1 times the largest distance of a training camera from their mean; 1 if all coincide.
double CameraRadius(const std::vector<View>& views) {
  const double radius = SpreadOf(TrainingViews(views)).radius;
  return radius > 0 ? 1.1 * radius : 1.0;
}

}  // namespace

std::array<double, 3> InCamera(const View& view, const std::array<double, 3>& point) {
  std::array<double, 3> t = view.translation;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) t[i] += view.rotation[3 * i + j] * point[j];
  }
  return t;
}

double DepthInView(const View& view, const std::array<float, 3>& point) {
  return DepthInView(view.rotation.data(), view.translation.data(), view.camera, point.data());
}

double SceneExtent(const std::vector<View>& views, const PointCloud& points) {
  std::vector<double> depths;
  for (const View& view : views) {
    if (!view.is_trained()) continue;
    for (const auto& point : points.positions) {
      const double depth = DepthInView(view, point);
      if (depth > 0) depths.push_back(depth);
    }
  }
  if (depths.empty()) return CameraRadius(views);
  return 0.5 * Median(std::move(depths));
}

CameraSpread SpreadOf(const std::vector<const View*>& views) {
  CameraSpread spread;
  std::vector<std::array<double, 3>> centers;
  centers.reserve(views.size());
  for (const View* view : views) centers.push_back(CameraCenter(*view));
  std::array<double, 3>& mean = spread.mean;
  for (const auto& center : centers) {
    for (std::size_t i = 0; i < 3; ++i) mean[i] += center[i] / static_cast<double>(centers.size());
  }
  for (const auto& center : centers) {
    spread.radius = std::max(spread.radius, std::hypot(center[0] - mean[0], center[1] - mean[1], center[2] - mean[2]));
  }
  return spread;
}

std::array<double, 3> SumOfUps(const std::vector<View>& views) {
  std::array<double, 3> up{};
  for (const View& view : views) {
    for (std::size_t i = 0; i < 3; ++i) up[i] -= view.rotation[3 + i];
  }
  return up;
}

double HorizontalAngle(const Camera& camera) {
  double t[3];
  splat::PointAt(camera.lens, camera.lens.cx + 0.5 * camera.width, camera.lens.cy, 1, t);
  return 2 * std::atan2(t[0], t[2]) * 180 / std::numbers::pi;
}

}  // namespace vesta::gs
