// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/viewer.h"

#include <fmt/format.h>

#include "apps/viewer/page.h"
#include "apps/viewer/scene_json.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::app {
namespace {

constexpr const char* kJson = "application/json";

HttpReply NoModelYet() { return {503, "text/plain", "there is no model yet\n"}; }

HttpReply FrameReply(std::string jpeg, const ShownModel::Shown& of) {
  return {200, "image/jpeg", std::move(jpeg), {{"X-Vesta-Version", std::to_string(of.version)}}};
}

}  // namespace

Viewer::Viewer(const ViewerPlace& place, const gs::Scene& scene, const std::array<float, 3>& background,
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
            return HttpReply{.body = "so be it\n"};
          }};
}

std::vector<gs::View> Viewer::ViewsOf(const ShownModel::Shown& shown) const {
  return gs::MovedViews(scene_, shown.cameras ? *shown.cameras : std::vector<gs::ViewUnknowns>());
}

HttpReply Viewer::State() {
  const ShownModel::Shown shown = model_.Look();
  const Index gaussians = training_ ? training_->gaussians() : shown.model ? shown.model->count : 0;
  return {200, kJson,
          fmt::format(R"({{"version": {}, "gaussians": {}, "cameras_move": {}, "training": {}}})", shown.version,
                      gaussians, shown.cameras != nullptr, training_ ? training_->StateJson() : "null")};
}

HttpReply Viewer::Scene() {
  const ShownModel::Shown shown = model_.Look();
  return shown.model ? HttpReply{200, kJson, SceneJson(scene_, ViewsOf(shown), *shown.model)} : NoModelYet();
}

HttpReply Viewer::Frame(const HttpQuery& query) {
  const ShownModel::Shown shown = model_.Look();
  const FrameRequest request =
      ParseFrameRequest(query, scene_, shown.cameras ? ViewsOf(shown) : std::vector<gs::View>());
  if (!shown.model) return NoModelYet();
  if (ShowsValues(request.kind)) return FrameOfValues(request, shown);
  return FrameReply(renderer_.Jpeg(*shown.model, request), shown);
}

HttpReply Viewer::FrameOfValues(const FrameRequest& request, const ShownModel::Shown& shown) {
  const bool is_worth = request.kind == FrameKind::kWorth;
  const auto values = values_.Ask(is_worth ? GaussianValue::kWorth : GaussianValue::kSupport, shown);
  constexpr int kAccepted = 202;
  if (!values) return {kAccepted, "text/plain", "what the Gaussians are to the training views is being measured\n"};
  return FrameReply(renderer_.Jpeg(*values->of.model, request, &values->places), values->of);
}

ViewerPlace PlaceOfViewer(const Flags& flags) { return {flags.bind, flags.port.value_or(0)}; }

ViewerPlace PlaceOfTrainingsView(const Flags& flags) {
  ViewerPlace place{flags.bind, 0};
  constexpr schema::Range kPorts{1, 65535};
  if (flags.view != kAnyPort && !schema::Numbers<int>::FromText(flags.view, kPorts, place.port)) {
    throw UsageError(fmt::format("--view={}: its value must be a port from 1 to 65535", flags.view));
  }
  return place;
}

}  // namespace vesta::app
