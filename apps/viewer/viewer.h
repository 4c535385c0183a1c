// SPDX-License-Identifier: Apache-2.0
// The viewer: an HTTP server with a page that shows a splat or a running training.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/viewer/frame_renderer.h"
#include "apps/viewer/gaussian_values.h"
#include "apps/viewer/http_server.h"
#include "apps/viewer/training_monitor.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// The network address and port on which the viewer listens.
struct ViewerAddress {
  std::string address = "127.0.0.1";
  int port = 0;  // 0: the first free one
};

class Viewer {
 public:
  // scene, model and training must outlive this object. scene may have no views. training: may be null. background:
  // 0..1. Throws Error (one line with --bind) if the server cannot listen on the address.
  Viewer(const ViewerAddress& place, const gs::Scene& scene, const std::array<float, 3>& background, ShownModel& model,
         TrainingMonitor* training = nullptr);

  // The link for a browser.
  std::string link() const { return server_.link(); }

 private:
  std::vector<HttpRoute> Routes();
  // The route of a page's command to the training.
  HttpRoute Command(const char* path, void (TrainingMonitor::*command)());
  // The scene's views, without images and with the cameras of the shown model.
  std::vector<gs::View> ViewsOf(const ShownModel::Shown& shown) const;
  // The replies to /state, /scene and /frame.
  HttpReply State();
  HttpReply Scene();
  HttpReply Frame(const HttpQuery& query);
  // A frame of values per Gaussian. Their model is the one of GaussianValues::Get, which may be earlier than `shown`.
  HttpReply FrameOfValues(const FrameRequest& request, const ShownModel::Shown& shown);

  const gs::Scene& scene_;
  ShownModel& model_;
  TrainingMonitor* training_;
  FrameRenderer renderer_;
  GaussianValues values_;
  HttpServer server_;  // declared last: serves as long as it exists
};

// The address from --bind and --port of `vesta view`, or from --bind and --view of a training. Throws UsageError if the
// value of --view is not a port.
ViewerAddress AddressOfViewer(const Flags& flags);
ViewerAddress AddressOfTrainingView(const Flags& flags);

// The viewer of a running training, with its monitor.
class TrainingView {
 public:
  // Parameters and errors are as for Viewer.
  TrainingView(const ViewerAddress& place, const gs::Scene& scene, const std::array<float, 3>& background)
      : viewer_(place, scene, background, model_, &monitor_) {}

  TrainingMonitor& monitor() { return monitor_; }
  std::string link() const { return viewer_.link(); }

 private:
  ShownModel model_;
  TrainingMonitor monitor_{model_};
  Viewer viewer_;
};

// The scene for the page as JSON, in the frame of the scene: "pivot" (the centre for orbiting: median of the points;
// without points, of the Gaussians), "radius" (their median distance from the pivot), "up" (unit vector, mean of the
// cameras), and "views", a list in the order of the scene with "name", "role" (train, held_out or test), "width",
// "height", "position", "rotation" (w,x,y,z; camera to world) and "focal" (in image heights). views: the views of the
// scene with their current cameras.
std::string SceneJson(const gs::Scene& scene, const std::vector<gs::View>& views, const gs::SplatModel& model);

// Median distance of the Gaussians from their median position. It is Scene::extent of a scene without views.
// Scene::extent determines the near plane.
double ExtentOf(const gs::SplatModel& model);

}  // namespace vesta::app
