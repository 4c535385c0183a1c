// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/frame_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "apps/report/error_map.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/io/images/image_file.h"
#include "splatting/render/look.h"
#include "splatting/render/surface.h"

namespace vesta::app {
namespace {

constexpr schema::Choice<FrameKind> kKinds[] = {{FrameKind::kRender, "render"},
                                                {FrameKind::kTruth, "truth"},
                                                {FrameKind::kDifference, "difference"},
                                                {FrameKind::kDepth, "depth"},
                                                {FrameKind::kMedianDepth, "median_depth"},
                                                {FrameKind::kNormals, "normals"},
                                                {FrameKind::kCount, "count"},
                                                {FrameKind::kRemovalCost, "removal_cost"},
                                                {FrameKind::kCoverage, "coverage"}};
static_assert(schema::AreDistinct(kKinds));

constexpr schema::Range kSide{16, 4096}, kFocal{0.05, 50}, kCoordinate{-1e12, 1e12};

const std::string& TextOf(const HttpQuery& query, const char* name) {
  const auto found = query.find(name);
  if (found == query.end()) Fail(kBadArgument, "{}: missing", name);
  return found->second;
}

template <class V>
V ValueOf(const HttpQuery& query, const char* name, schema::Range range) {
  V value{};
  if (!schema::Numbers<V>::FromText(TextOf(query, name), range, value)) {
    Fail(kBadArgument, "{}: not a value from {} to {}", name, range.min, range.max);
  }
  return value;
}

FrameKind KindOf(const std::string& name) {
  for (const auto& choice : kKinds) {
    if (name == choice.name) return choice.value;
  }
  Fail(kBadArgument,
       "kind: must be render, truth, difference, depth, median_depth, normals, count, removal_cost or coverage");
}

gs::View FreeView(const HttpQuery& query, gs::ImageSize size) {
  const auto centre = ValueOf<std::array<double, 3>>(query, "position", kCoordinate);
  const auto rotation = ValueOf<std::array<double, 4>>(query, "rotation", {-1e3, 1e3});
  const double focal = ValueOf<double>(query, "focal", kFocal) * size.height;
  double length = 0;
  for (const double q : rotation) length += q * q;
  if (length < 1e-12) Fail(kBadArgument, "rotation: the quaternion must not be zero");
  gs::View view;
  view.camera = {size.width, size.height, {focal, focal, 0.5 * size.width, 0.5 * size.height}};
  double to_camera[4];
  QuaternionConjugate(rotation.data(), to_camera);
  RotationFromQuaternion(to_camera, view.rotation.data());
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) view.translation[i] -= view.rotation[3 * i + k] * centre[k];
  }
  return view;
}

gs::View ViewOfPhoto(const gs::View& photo, gs::ImageSize size) {
  gs::View view;
  view.camera = gs::ResizeCamera(photo.camera, size.width, size.height);
  view.rotation = photo.rotation, view.translation = photo.translation;
  return view;
}

}  // namespace

std::string FrameRenderer::Jpeg(const gs::SplatModel& model, const FrameRequest& request,
                                const std::vector<float>* scale_positions) {
  constexpr int kQuality = 85;
  gs::Image picture;
  {
    const std::lock_guard lock(mutex_);
    picture = Picture(model, request, scale_positions);
  }
  return gs::EncodeJpeg(picture, kQuality);
}

gs::Image FrameRenderer::Picture(const gs::SplatModel& model, const FrameRequest& request,
                                 const std::vector<float>* scale_positions) {
  const gs::Camera& camera = request.view.camera;
  gs::Image truth;
  if (request.kind == FrameKind::kTruth || request.kind == FrameKind::kDifference) {
    const gs::View& photo = scene_.views[*request.photo];
    // Bypasses the store's cache, whose order serves the training.
    truth = gs::ResizeArea(photo.stored ? *photo.stored->Read() : photo.image, camera.width, camera.height);
  }
  if (request.kind == FrameKind::kTruth) return truth;
  const splat::Model<float> kernel_model = gs::ToKernelModel(model);
  splat::PosedCamera posed = gs::ToPosedCamera(request.view, gs::NearPlane(scene_));
  // Free cameras of the page and a splat in training have no eps2d and are not antialiased.
  if (scene_.views.empty()) {
    posed.eps2d = model.eps2d, posed.antialiased = model.antialiased;
  } else {
    const gs::Camera& filtered = scene_.views.front().camera;
    posed.eps2d = filtered.eps2d, posed.antialiased = filtered.antialiased;
  }
  splats_.Build(kernel_model, posed, background_.data(), workspace_);
  switch (request.kind) {
    case FrameKind::kCount:
      return CountImage();
    case FrameKind::kDepth:
      return DepthImage(kernel_model, gs::DepthKind::kMean);
    case FrameKind::kMedianDepth:
      return DepthImage(kernel_model, gs::DepthKind::kMedian);
    case FrameKind::kNormals:
      return gs::NormalColors(gs::NormalsOf(splats_, kernel_model, workspace_));
    case FrameKind::kRemovalCost:
    case FrameKind::kCoverage:
      return ValueImage(*scale_positions);
    default:
      break;
  }
  gs::Image image(camera.width, camera.height);
  splats_.Render(image.rgb.data());
  return request.kind == FrameKind::kDifference ? ErrorMap(image, truth) : image;
}

gs::Image FrameRenderer::DepthImage(const splat::Model<float>& model, gs::DepthKind kind) {
  return gs::DepthColors(gs::DepthOf(splats_, model, workspace_, kind), 2 * scene_.extent);
}

gs::Image FrameRenderer::ValueImage(const std::vector<float>& scale_positions) {
  gs::Image image(splats_.camera().width, splats_.camera().height);
  image.rgb = gs::Blend(splats_, workspace_, [&](Index i) {
    return gs::OnScale(gs::kVioletToYellow, scale_positions[static_cast<std::size_t>(i)]);
  });
  return image;
}

gs::Image FrameRenderer::CountImage() const {
  const splat::TileLists<float> lists = splats_.Lists();
  gs::Image image(lists.width, lists.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int tile = y / splat::kTileSize * lists.tiles_x + x / splat::kTileSize;
      const auto count = static_cast<float>(lists.tile_begin[tile + 1] - lists.tile_begin[tile]);
      const std::array<float, 3> color = HeatColor(std::min(count / kManySplats, 1.0f));
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      for (int c = 0; c < 3; ++c) image.plane(c)[pixel] = color[static_cast<std::size_t>(c)];
    }
  }
  return image;
}

FrameRequest ParseFrameRequest(const HttpQuery& query, const gs::Scene& scene, const std::vector<gs::View>& moved) {
  FrameRequest request;
  request.kind = KindOf(TextOf(query, "kind"));
  if (ShowsValues(request.kind) && scene.views.empty())
    Fail(kBadArgument, "kind: removal_cost and coverage need a scene");
  const bool shows_photo = request.kind == FrameKind::kTruth || request.kind == FrameKind::kDifference;
  gs::ImageSize size{ValueOf<int>(query, "width", kSide), ValueOf<int>(query, "height", kSide)};
  if (!query.contains("photo")) {
    if (shows_photo) Fail(kBadArgument, "photo: missing; truth and difference need a photograph");
    request.view = FreeView(query, size);
    return request;
  }
  if (scene.views.empty()) Fail(kBadArgument, "photo: there is no scene");
  request.photo = ValueOf<std::size_t>(query, "photo", {0, static_cast<double>(scene.views.size()) - 1});
  const gs::View& photo = scene.views[*request.photo];
  if (shows_photo) {
    if (photo.image.empty() && !photo.stored) Fail(kNotFound, "photo: not in memory");
    size = {std::min(size.width, photo.camera.width), std::min(size.height, photo.camera.height)};
  }
  request.view = ViewOfPhoto(moved.empty() ? photo : moved[*request.photo], size);
  return request;
}

}  // namespace vesta::app
