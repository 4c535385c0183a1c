// SPDX-License-Identifier: Apache-2.0
#include "splatting/points/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/profile.h"
#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "splatting/points/likely_depths.h"

namespace vesta::gs {
namespace {

using Vector3 = std::array<float, 3>;
using Color = std::array<std::uint8_t, 3>;

constexpr int kLongestSide = 320;  // images are shrunk to this size, pixels
constexpr int kRadius = 2;         // a window has 2 kRadius + 1 pixels per side
constexpr int kWindow = (2 * kRadius + 1) * (2 * kRadius + 1);
constexpr float kLeastContrast = 0.01f;  // standard deviation of the pixels of a window
constexpr float kLeastScore = 0.7f;
constexpr float kLeastMargin = 0.1f;  // over the scores of depths more than kPeak steps away
constexpr int kPeak = 3;
constexpr int kFewestSteps = 16, kMostSteps = 256;
constexpr double kNearest = 0.125;  // of the likely depth
constexpr std::size_t kOthers = 4;
constexpr double kBestAngle = 3 * std::numbers::pi / 180;  // between the rays of two views to a likely point
constexpr double kLeastAngle = 1e-4;
constexpr double kLeastAxes = 0.7;  // cosine of the angle between two optical axes
constexpr Index kRounds = 8;        // tries at most kRounds * count pixels
constexpr float kUnseen = -2;       // below every correlation

// A training view at a small size.
struct SmallView {
  const View* view;
  Camera camera;
  std::vector<float> green;  // NaN where the mask excludes the pixel
  std::vector<Color> colors;
  double likely_depth;
  std::vector<std::size_t> others;  // the views that it is compared with
  float widest = 0;                 // largest distance to their cameras
};

SmallView Shrink(const View& view, double likely_depth) {
  const std::shared_ptr<const Image> photograph = view.Photograph();
  const double scale = std::min(1.0, double{kLongestSide} / std::max(photograph->width, photograph->height));
  const auto shrunk = [&](int side) { return std::max(1, static_cast<int>(side * scale)); };
  const Image image = ResizeArea(*photograph, shrunk(photograph->width), shrunk(photograph->height));
  SmallView small{.view = &view,
                  .camera = ResizeCamera(view.camera, image.width, image.height),
                  .green = {image.plane(1), image.plane(1) + image.num_pixels()},
                  .colors = std::vector<Color>(image.num_pixels()),
                  .likely_depth = likely_depth,
                  .others = {}};
  for (std::size_t i = 0; i < image.num_pixels(); ++i) {
    for (int c = 0; c < 3; ++c) small.colors[i][static_cast<std::size_t>(c)] = QuantizeColor(image.plane(c)[i]);
    if (!image.mask.empty() && image.mask[i] == 0) small.green[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return small;
}

// Chooses for each view the others in which rays to a likely point differ from its own by nearly kBestAngle: smaller
// angles give inaccurate depths, larger ones different pictures.
void ChooseOthers(std::vector<SmallView>* views) {
  for (SmallView& small : *views) {
    const View& view = *small.view;
    const std::array<double, 3> center = CameraCenter(view);
    std::array<double, 3> ray;
    for (std::size_t i = 0; i < 3; ++i) ray[i] = view.rotation[6 + i] * small.likely_depth;
    std::vector<std::pair<double, std::size_t>> candidates;
    std::vector<double> distances(views->size());
    for (std::size_t k = 0; k < views->size(); ++k) {
      const View& other = *(*views)[k].view;
      const std::array<double, 3> from = CameraCenter(other);
      double length2 = 0, dot = 0, axes = 0, distance2 = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double apart = from[i] - center[i], to_point = ray[i] - apart;
        distance2 += apart * apart, length2 += to_point * to_point, dot += to_point * ray[i];
        axes += view.rotation[6 + i] * other.rotation[6 + i];
      }
      distances[k] = std::sqrt(distance2);
      const double angle = std::acos(std::clamp(dot / (small.likely_depth * std::sqrt(length2)), -1.0, 1.0));
      if (angle > kLeastAngle && axes > kLeastAxes) candidates.emplace_back(std::abs(std::log(angle / kBestAngle)), k);
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.resize(std::min(candidates.size(), kOthers));
    for (const auto& [rank, k] : candidates) {
      small.others.push_back(k);
      small.widest = std::max(small.widest, static_cast<float>(distances[k]));
    }
  }
}

// Calls body(k, i, j) for the pixels of a window, k = 0, 1, ...
template <class Body>
void ForWindow(const Body& body) {
  std::size_t k = 0;
  for (int j = -kRadius; j <= kRadius; ++j) {
    for (int i = -kRadius; i <= kRadius; ++i) body(k++, static_cast<float>(i), static_cast<float>(j));
  }
}

// A parallelogram in an image: pixel (i, j) of the window is at (u + i ui + j uj, v + i vi + j vj), pixels.
struct Patch {
  float u, v, ui = 1, vi = 0, uj = 0, vj = 1;
};

// Interpolated values in the patch; false if it is not inside the image.
bool ReadPatch(const SmallView& view, const Patch& patch, std::array<float, kWindow>* values) {
  const int width = view.camera.width;
  const float x = patch.u - 0.5f, y = patch.v - 0.5f;
  const float across = kRadius * (std::abs(patch.ui) + std::abs(patch.uj));
  const float down = kRadius * (std::abs(patch.vi) + std::abs(patch.vj));
  if (!(x - across >= 0 && y - down >= 0 && x + across < static_cast<float>(width - 1) &&
        y + down < static_cast<float>(view.camera.height - 1))) {
    return false;
  }
  ForWindow([&](std::size_t k, float i, float j) {
    const float xk = x + i * patch.ui + j * patch.uj, yk = y + i * patch.vi + j * patch.vj;
    const auto column = static_cast<int>(xk), row = static_cast<int>(yk);
    const float* p = view.green.data() + row * width + column;
    const float a = xk - static_cast<float>(column), b = yk - static_cast<float>(row);
    const float above = p[0] + a * (p[1] - p[0]), below = p[width] + a * (p[width + 1] - p[width]);
    (*values)[k] = above + b * (below - above);
  });
  return true;
}

// The pixels around one pixel, minus their mean.
struct Window {
  std::array<float, kWindow> values;
  float sum_of_squares;
};

// nullopt if it is not inside the image, masked, or without contrast.
std::optional<Window> WindowAt(const SmallView& view, float u, float v) {
  Window window{};
  if (!ReadPatch(view, {u, v}, &window.values)) return std::nullopt;
  float sum = 0;
  for (const float value : window.values) sum += value;
  for (float& value : window.values) {
    value -= sum / kWindow;
    window.sum_of_squares += value * value;
  }
  const bool has_contrast = window.sum_of_squares >= kWindow * kLeastContrast * kLeastContrast;
  return has_contrast ? std::optional(window) : std::nullopt;
}

// Where another view sees the pixels of a window at inverse depth w: pixel (i, j) of the window is in direction
// origin + i across + j down + w shift, in the camera coordinates of the other view.
struct Transfer {
  Vector3 origin, across, down, shift;
};

// x, y: the window's centre, on the image plane at depth 1.
Transfer TransferTo(const View& other, const SmallView& from, float x, float y) {
  const View& view = *from.view;
  const std::array<double, 3> center = CameraCenter(view), shift = InCamera(other, center);
  const splat::Lens& lens = from.camera.lens;
  Transfer transfer;
  for (std::size_t i = 0; i < 3; ++i) {
    double row[3] = {};  // of the rotation from the camera of `from` to the other
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) row[j] += other.rotation[3 * i + k] * view.rotation[3 * j + k];
    }
    transfer.origin[i] = static_cast<float>(row[0]) * x + static_cast<float>(row[1]) * y + static_cast<float>(row[2]);
    transfer.across[i] = static_cast<float>(row[0] / lens.fx);
    transfer.down[i] = static_cast<float>(row[1] / lens.fy);
    transfer.shift[i] = static_cast<float>(shift[i]);
  }
  return transfer;
}

// The window's patch in another image at inverse depth w, to first order around its centre; nullopt behind the camera.
std::optional<Patch> PatchAt(const SmallView& other, const Transfer& transfer, float w) {
  constexpr float kLeastDepth = 1e-6f;
  const splat::Lens& lens = other.camera.lens;
  const auto at = [&](std::size_t axis) { return transfer.origin[axis] + w * transfer.shift[axis]; };
  const float z = at(2);
  if (!(z > kLeastDepth)) return std::nullopt;
  const float x = at(0) / z, y = at(1) / z;
  const float fx = static_cast<float>(lens.fx) / z, fy = static_cast<float>(lens.fy) / z;
  const Vector3 &across = transfer.across, &down = transfer.down;
  return Patch{.u = static_cast<float>(lens.fx) * x + static_cast<float>(lens.cx),
               .v = static_cast<float>(lens.fy) * y + static_cast<float>(lens.cy),
               .ui = fx * (across[0] - x * across[2]),
               .vi = fy * (across[1] - y * across[2]),
               .uj = fx * (down[0] - x * down[2]),
               .vj = fy * (down[1] - y * down[2])};
}

// Normalized cross-correlation of the window with what `other` sees at inverse depth w, -1 to 1; kUnseen if a pixel is
// outside the image of `other`, behind its camera, or masked.
float Correlation(const Window& window, const SmallView& other, const Transfer& transfer, float w) {
  constexpr float kLeastVariance = 1e-6f;
  const std::optional<Patch> patch = PatchAt(other, transfer, w);
  std::array<float, kWindow> values;
  if (!patch || !ReadPatch(other, *patch, &values)) return kUnseen;
  float sum = 0, squares = 0, products = 0;
  for (std::size_t k = 0; k < kWindow; ++k) {
    sum += values[k], squares += values[k] * values[k], products += values[k] * window.values[k];
  }
  const float variance = squares - sum * sum / kWindow;
  if (std::isnan(variance)) return kUnseen;
  return variance > kWindow * kLeastVariance ? products / std::sqrt(variance * window.sum_of_squares) : 0;
}

// The mean of the two largest correlations; the largest one if there is only one other view. kUnseen without them.
class Score {
 public:
  void Add(float correlation) {
    second_ = std::max(second_, std::min(first_, correlation));
    first_ = std::max(first_, correlation);
  }
  float Mean(std::size_t others) const {
    if (others == 1) return first_;
    return second_ == kUnseen ? kUnseen : (first_ + second_) / 2;
  }

 private:
  float first_ = kUnseen, second_ = kUnseen;
};

// Offset of the maximum of a parabola through the scores before, at and after a peak, -0.5 to 0.5 steps.
float PeakOffset(const std::vector<float>& scores, std::size_t at) {
  if (at == 0 || at + 1 == scores.size() || scores[at - 1] == kUnseen || scores[at + 1] == kUnseen) return 0;
  const float bend = scores[at - 1] - 2 * scores[at] + scores[at + 1];
  return bend < 0 ? 0.5f * (scores[at - 1] - scores[at + 1]) / bend : 0;
}

// The distinct peak of the scores, in steps; nullopt without one.
std::optional<float> DistinctPeak(const std::vector<float>& scores) {
  const auto best = std::max_element(scores.begin(), scores.end());
  const std::ptrdiff_t at = best - scores.begin();
  if (!(*best >= kLeastScore)) return std::nullopt;
  for (std::ptrdiff_t s = 0; s < std::ssize(scores); ++s) {
    if (std::abs(s - at) > kPeak && *best - scores[static_cast<std::size_t>(s)] < kLeastMargin) return std::nullopt;
  }
  return static_cast<float>(at) + PeakOffset(scores, static_cast<std::size_t>(at));
}

struct FoundPoint {
  Vector3 position, color;
};

std::optional<FoundPoint> Sweep(const std::vector<SmallView>& views, const SmallView& small, float u, float v) {
  if (small.others.empty()) return std::nullopt;
  const std::optional<Window> window = WindowAt(small, u, v);
  if (!window) return std::nullopt;
  const splat::Lens& lens = small.camera.lens;
  const auto x = static_cast<float>((u - lens.cx) / lens.fx), y = static_cast<float>((v - lens.cy) / lens.fy);
  const auto nearest = static_cast<float>(kNearest * small.likely_depth);
  // From infinity to the nearest depth, a point moves in the image of the farthest camera by about this many pixels.
  const float pixels = static_cast<float>(lens.fx) * small.widest / nearest;
  const int steps = static_cast<int>(std::clamp(pixels, float{kFewestSteps}, float{kMostSteps}));
  const float step = 1 / (static_cast<float>(steps) * nearest);
  std::vector<Score> all(static_cast<std::size_t>(steps) + 1);
  for (const std::size_t k : small.others) {
    const Transfer transfer = TransferTo(*views[k].view, small, x, y);
    for (std::size_t s = 0; s < all.size(); ++s) {
      all[s].Add(Correlation(*window, views[k], transfer, static_cast<float>(s) * step));
    }
  }
  std::vector<float> scores(all.size());
  for (std::size_t s = 0; s < all.size(); ++s) scores[s] = all[s].Mean(small.others.size());
  const std::optional<float> peak = DistinctPeak(scores);
  if (!peak) return std::nullopt;
  constexpr float kFarthest = 0.25f;  // steps; stands for infinity
  const double depth = 1 / double{std::max(*peak, kFarthest) * step};
  FoundPoint found;
  const View& view = *small.view;
  const std::array<double, 3> center = CameraCenter(view);
  const auto pixel =
      static_cast<std::size_t>(v) * static_cast<std::size_t>(small.camera.width) + static_cast<std::size_t>(u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double ray = view.rotation[i] * double{x} + view.rotation[3 + i] * double{y} + view.rotation[6 + i];
    found.position[i] = static_cast<float>(center[i] + depth * ray);
    found.color[i] = static_cast<float>(small.colors[pixel][i]) / 255.0f;
  }
  return found;
}

std::vector<SmallView> SmallViews(const std::vector<View>& views) {
  std::vector<View> cameras;
  for (const View* view : TrainingViews(views)) {
    View camera;  // without the photograph
    camera.rotation = view->rotation, camera.translation = view->translation;
    cameras.push_back(std::move(camera));
  }
  const std::vector<double> depths = LikelyDepths(cameras);
  std::vector<SmallView> small;
  small.reserve(cameras.size());
  for (const View* view : TrainingViews(views)) small.push_back(Shrink(*view, depths[small.size()]));
  ChooseOthers(&small);
  return small;
}

}  // namespace

PointCloud PointsByPlaneSweep(const std::vector<View>& views, Index count, std::uint64_t seed) {
  const ScopedPhase phase("plane sweep");
  const std::vector<SmallView> small = SmallViews(views);
  PointCloud cloud;
  if (small.empty()) return cloud;
  std::vector<std::optional<FoundPoint>> found(static_cast<std::size_t>(count));
  for (Index round = 0; round < kRounds && cloud.size() < count; ++round) {
    ParallelFor(count, 16, [&](Index i) {
      const auto k = static_cast<std::size_t>(i);
      const SmallView& view = small[k % small.size()];
      CounterRandom random(seed, static_cast<std::uint64_t>(round), static_cast<std::uint64_t>(i));
      const double u = random.Uniform() * view.camera.width, v = random.Uniform() * view.camera.height;
      found[k] = Sweep(small, view, static_cast<float>(u), static_cast<float>(v));
    });
    for (const std::optional<FoundPoint>& point : found) {
      if (!point || cloud.size() == count) continue;
      cloud.positions.push_back(point->position);
      cloud.colors.push_back(point->color);
    }
  }
  return cloud;
}

}  // namespace vesta::gs
