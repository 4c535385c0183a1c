// SPDX-License-Identifier: Apache-2.0
// The viewer: serves a page that shows a splat or a running training, and reads its flags.
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

// The address on which the viewer listens (--bind, --port).
struct ViewerAddress {
  std::string address = "127.0.0.1";
  int port = 0;  // 0: the first free one
};

class Viewer {
 public:
  // scene (may have no views), model and training (null: none) must outlive this object. background: colour, 0..1.
  // Throws Error if the address cannot be bound.
  Viewer(const ViewerAddress& place, const gs::Scene& scene, const std::array<float, 3>& background, ShownModel& model,
         TrainingMonitor* training = nullptr);

  // The link for a browser.
  std::string link() const { return server_.link(); }

 private:
  std::vector<HttpRoute> Routes();
  HttpRoute Command(const char* path, void (TrainingMonitor::*command)());
  // The views of the scene without images, with the cameras of the shown model.
  std::vector<gs::View> ViewsOf(const ShownModel::Shown& shown) const;
  HttpReply State();
  HttpReply Scene();
  HttpReply Frame(const HttpQuery& query);
  // Renders the model whose values were measured, which may be an earlier one.
  HttpReply FrameOfValues(const FrameRequest& request, const ShownModel::Shown& shown);

  const gs::Scene& scene_;
  ShownModel& model_;
  TrainingMonitor* training_;
  FrameRenderer renderer_;
  GaussianValues values_;
  HttpServer server_;  // last member: it serves requests during its whole lifetime
};

// The address of `vesta view` (--port), and of a training (--view). Throws UsageError if --view is not a port.
ViewerAddress AddressOfViewer(const Flags& flags);
ViewerAddress AddressOfTrainingView(const Flags& flags);

// The page of a running training.
class TrainingView {
 public:
  // As for Viewer.
  TrainingView(const ViewerAddress& place, const gs::Scene& scene, const std::array<float, 3>& background)
      : viewer_(place, scene, background, model_, &monitor_) {}

  TrainingMonitor& monitor() { return monitor_; }
  std::string link() const { return viewer_.link(); }

 private:
  ShownModel model_;
  TrainingMonitor monitor_{model_};
  Viewer viewer_;
};

// "pivot" (centre for orbiting: median of the points, else of the Gaussians), "radius" (half of them
// are within), "up" (unit vector, mean of the cameras), all in the frame of the scene, and "views" in the order of the
// scene: "name", "role" (train, held_out or test), "width", "height", "position", "rotation" (w,x,y,z; camera to world)
// and "focal" in image heights. views: the views of the scene with their current cameras.
std::string SceneJson(const gs::Scene& scene, const std::vector<gs::View>& views, const gs::SplatModel& model);

// The radius of the model, as the extent of a scene without views; it determines the near plane.
double ExtentOf(const gs::SplatModel& model);

}  // namespace vesta::app
