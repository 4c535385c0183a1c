// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "apps/viewer/page.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::app {
namespace {

constexpr const char* kJson = "application/json";

HttpReply NoModelYet() { return {503, "text/plain", "there is no model yet\n"}; }

HttpReply FrameReply(std::string jpeg, const ShownModel::Shown& of) {
  return {200, "image/jpeg", std::move(jpeg), {{"X-Vesta-Version", std::to_string(of.version)}}};
}

using Json = nlohmann::json;
using Point = std::array<double, 3>;

struct Place {
  Point middle{};
  double radius = 1;
};

// Median and radius of `count` points point(i), from a sample of large sets.
template <class PointAt>
Place PlaceOf(Index count, const PointAt& point) {
  constexpr Index kEnough = 20000;
  Place place;
  if (count == 0) return place;
  const Index step = std::max<Index>(1, count / kEnough);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (Index i = 0; i < count; i += step) values.push_back(point(i)[k]);
    place.middle[k] = gs::Median(std::move(values));
  }
  std::vector<double> distances;
  for (Index i = 0; i < count; i += step) {
    const Point p = point(i);
    distances.push_back(std::hypot(p[0] - place.middle[0], p[1] - place.middle[1], p[2] - place.middle[2]));
  }
  const double radius = gs::Median(std::move(distances));
  if (radius > 0) place.radius = radius;
  return place;
}

Place PlaceOf(const gs::SplatModel& model) {
  return PlaceOf(model.count, [&](Index i) {
    Point point;
    for (int k = 0; k < 3; ++k) point[static_cast<std::size_t>(k)] = static_cast<double>(model.Value(k, i));
    return point;
  });
}

Place PlaceOf(const gs::PointCloud& points) {
  return PlaceOf(points.size(), [&](Index i) {
    const auto& p = points.positions[static_cast<std::size_t>(i)];
    return Point{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  });
}

// Mean up axis of the cameras; without cameras (0, -1, 0), as for identity rotation.
Point UpOf(const gs::Scene& scene) {
  Point up = gs::SumOfUps(scene.views);
  const double length = std::hypot(up[0], up[1], up[2]);
  if (length < 1e-6 * static_cast<double>(scene.views.size()) || length == 0) return {0, -1, 0};
  for (double& x : up) x /= length;
  return up;
}

const char* RoleName(gs::ViewRole role) {
  switch (role) {
    case gs::ViewRole::kTraining:
      return "train";
    case gs::ViewRole::kHeldOut:
      return "held_out";
    case gs::ViewRole::kTest:
      return "test";
  }
  return "?";
}

Json ViewJson(const gs::View& view) {
  double to_camera[4];
  std::array<double, 4> to_world;
  QuaternionFromRotation(view.rotation.data(), to_camera);
  QuaternionConjugate(to_camera, to_world.data());
  return {{"name", view.name},
          {"role", RoleName(view.role)},
          {"width", view.camera.width},
          {"height", view.camera.height},
          {"position", gs::CameraCenter(view)},
          {"rotation", to_world},
          {"focal", view.camera.lens.fy / view.camera.height}};
}

}  // namespace

Viewer::Viewer(const ViewerAddress& place, const gs::Scene& scene, const std::array<float, 3>& background,
               ShownModel& model, TrainingMonitor* training)
    : scene_(scene),
      model_(model),
      training_(training),
      renderer_(scene, background),
      values_(scene, ToDouble(background)),
      server_(place.address, place.port, Routes()) {}

std::vector<HttpRoute> Viewer::Routes() {
  using Guard = HttpRoute::Guard;
  std::vector<HttpRoute> routes = {
      {"GET", "/", Guard::kLink,
       [](const HttpQuery&) {
         return HttpReply{200, "text/html; charset=utf-8", std::string(ViewerPage())};
       }},
      {"GET", "/page.css", Guard::kNone,
       [](const HttpQuery&) {
         return HttpReply{200, "text/css; charset=utf-8", std::string(ViewerStyle())};
       }},
      {"GET", "/page.js", Guard::kNone,
       [](const HttpQuery&) {
         return HttpReply{200, "text/javascript; charset=utf-8", ViewerScript()};
       }},
      {"GET", "/scene", Guard::kToken, [this](const HttpQuery&) { return Scene(); }},
      {"GET", "/frame", Guard::kToken, [this](const HttpQuery& query) { return Frame(query); }},
      {"GET", "/state", Guard::kToken, [this](const HttpQuery&) { return State(); }},
  };
  if (!training_) return routes;
  routes.push_back(Command("/pause", &TrainingMonitor::Pause));
  routes.push_back(Command("/resume", &TrainingMonitor::Resume));
  routes.push_back(Command("/checkpoint", &TrainingMonitor::SaveCheckpoint));
  routes.push_back(Command("/stop", &TrainingMonitor::Stop));
  return routes;
}

HttpRoute Viewer::Command(const char* path, void (TrainingMonitor::*command)()) {
  return {"POST", path, HttpRoute::Guard::kToken, [this, command](const HttpQuery&) {
            (training_->*command)();
            return HttpReply{.body = "done\n"};
          }};
}

std::vector<gs::View> Viewer::ViewsOf(const ShownModel::Shown& shown) const {
  return gs::MovedViews(scene_, shown.cameras ? *shown.cameras : std::vector<gs::ViewUnknowns>());
}

HttpReply Viewer::State() {
  const ShownModel::Shown shown = model_.Get();
  const Index gaussians = training_ ? training_->gaussians() : shown.model ? shown.model->count : 0;
  return {200, kJson,
          fmt::format(R"({{"version": {}, "gaussians": {}, "cameras_move": {}, "training": {}}})", shown.version,
                      gaussians, shown.cameras != nullptr, training_ ? training_->StateJson() : "null")};
}

HttpReply Viewer::Scene() {
  const ShownModel::Shown shown = model_.Get();
  return shown.model ? HttpReply{200, kJson, SceneJson(scene_, ViewsOf(shown), *shown.model)} : NoModelYet();
}

HttpReply Viewer::Frame(const HttpQuery& query) {
  const ShownModel::Shown shown = model_.Get();
  const FrameRequest request =
      ParseFrameRequest(query, scene_, shown.cameras ? ViewsOf(shown) : std::vector<gs::View>());
  if (!shown.model) return NoModelYet();
  if (ShowsValues(request.kind)) return FrameOfValues(request, shown);
  return FrameReply(renderer_.Jpeg(*shown.model, request), shown);
}

HttpReply Viewer::FrameOfValues(const FrameRequest& request, const ShownModel::Shown& shown) {
  const bool is_removal_cost = request.kind == FrameKind::kRemovalCost;
  const auto values = values_.Get(is_removal_cost ? GaussianValue::kRemovalCost : GaussianValue::kCoverage, shown);
  constexpr int kAccepted = 202;
  if (!values) return {kAccepted, "text/plain", "the values of the Gaussians are being computed\n"};
  return FrameReply(renderer_.Jpeg(*values->of.model, request, &values->scale_positions), values->of);
}

ViewerAddress AddressOfViewer(const Flags& flags) { return {flags.bind, flags.port.value_or(0)}; }

ViewerAddress AddressOfTrainingView(const Flags& flags) {
  ViewerAddress place{flags.bind, 0};
  constexpr schema::Range kPorts{1, 65535};
  if (flags.view != kAnyPort && !schema::Numbers<int>::FromText(flags.view, kPorts, place.port)) {
    throw UsageError(fmt::format("--view={}: its value must be a port from 1 to 65535", flags.view));
  }
  return place;
}

double ExtentOf(const gs::SplatModel& model) { return PlaceOf(model).radius; }

std::string SceneJson(const gs::Scene& scene, const std::vector<gs::View>& views, const gs::SplatModel& model) {
  const Place place = scene.points.size() > 0 ? PlaceOf(scene.points) : PlaceOf(model);
  Json cameras = Json::array();
  for (const gs::View& view : views) cameras.push_back(ViewJson(view));
  const Json json = {{"pivot", place.middle}, {"radius", place.radius}, {"up", UpOf(scene)}, {"views", cameras}};
  // View names need not be valid UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace vesta::app
