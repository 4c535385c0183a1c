// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/frame_request.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"
#include "kernels/math/quaternion.h"

namespace vesta::app {
namespace {

constexpr schema::Choice<FrameKind> kKinds[] = {{FrameKind::kRender, "render"},
                                                {FrameKind::kTruth, "truth"},
                                                {FrameKind::kDifference, "difference"},
                                                {FrameKind::kDepth, "depth"},
                                                {FrameKind::kMedianDepth, "median_depth"},
                                                {FrameKind::kNormals, "normals"},
                                                {FrameKind::kCount, "count"},
                                                {FrameKind::kWorth, "worth"},
                                                {FrameKind::kSupport, "support"}};
static_assert(schema::EachOnce(kKinds));

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
  Fail(kBadArgument, "kind: must be render, truth, difference, depth, median_depth, normals, count, worth or support");
}

gs::View FreeView(const HttpQuery& query, gs::ImageSize size) {
  const auto centre = ValueOf<std::array<double, 3>>(query, "position", kCoordinate);
  const auto rotation = ValueOf<std::array<double, 4>>(query, "rotation", {-1e3, 1e3});
  const double focal = ValueOf<double>(query, "focal", kFocal) * size.height;
  double length = 0;
  for (const double q : rotation) length += q * q;
  if (length < 1e-12) Fail(kBadArgument, "rotation: a quaternion of zero turns nothing");
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

FrameRequest ParseFrameRequest(const HttpQuery& query, const gs::Scene& scene, const std::vector<gs::View>& moved) {
  FrameRequest request;
  request.kind = KindOf(TextOf(query, "kind"));
  if (ShowsValues(request.kind) && scene.views.empty())
    Fail(kBadArgument, "kind: worth and support are to views; there is no scene");
  const bool shows_photo = request.kind == FrameKind::kTruth || request.kind == FrameKind::kDifference;
  gs::ImageSize size{ValueOf<int>(query, "width", kSide), ValueOf<int>(query, "height", kSide)};
  if (!query.contains("photo")) {
    if (shows_photo) Fail(kBadArgument, "photo: missing; truth and difference are those of a photograph");
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
