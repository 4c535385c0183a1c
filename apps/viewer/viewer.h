// SPDX-License-Identifier: Apache-2.0
// The viewer: a page served to a browser, of a splat or of a training while it runs, and its flags.
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

// Where it listens (--bind, --port).
struct ViewerPlace {
  std::string address = "127.0.0.1";
  int port = 0;  // 0: a free one
};

class Viewer {
 public:
  // The scene (without views where there are none), the model that is shown, and the training, if it is that of one,
  // must outlive it. background: behind all Gaussians, 0..1. Throws Error where the place cannot be bound.
  Viewer(const ViewerPlace& place, const gs::Scene& scene, const std::array<float, 3>& background, ShownModel& model,
         TrainingMonitor* training = nullptr);

  // To be opened in a browser.
  std::string link() const { return server_.link(); }

 private:
  std::vector<HttpRoute> Routes();
  HttpRoute Command(const char* path, void (TrainingMonitor::*command)());
  // Those of the scene, without images, where their cameras stand with what is shown.
  std::vector<gs::View> ViewsOf(const ShownModel::Shown& shown) const;
  HttpReply State();
  HttpReply Scene();
  HttpReply Frame(const HttpQuery& query);
  // Of the values' own model, which may be an earlier one.
  HttpReply FrameOfValues(const FrameRequest& request, const ShownModel::Shown& shown);

  const gs::Scene& scene_;
  ShownModel& model_;
  TrainingMonitor* training_;
  FrameRenderer renderer_;
  GaussianValues values_;
  HttpServer server_;  // last: it answers from the first moment to its end
};

// Of `view`, by --port, and of a training, by --view. Throws UsageError where --view is no port.
ViewerPlace PlaceOfViewer(const Flags& flags);
ViewerPlace PlaceOfTrainingsView(const Flags& flags);

// The page of a training while it runs.
class TrainingView {
 public:
  // As Viewer's.
  TrainingView(const ViewerPlace& place, const gs::Scene& scene, const std::array<float, 3>& background)
      : viewer_(place, scene, background, model_, &monitor_) {}

  TrainingMonitor& monitor() { return monitor_; }
  std::string link() const { return viewer_.link(); }

 private:
  ShownModel model_;
  TrainingMonitor monitor_{model_};
  Viewer viewer_;
};

// "pivot" (what to turn about: the middle of the points, else of the Gaussians), "radius" (half of them are within),
// "up" (a unit vector: that of the cameras), all in the scene's frame, and "views": for each of the scene's, in their
// order, "name", "role" (train, held_out or test), "width", "height", "position", "rotation" (w,x,y,z; camera to world)
// and "focal" in heights of the picture. views: the scene's, where their cameras stand.
std::string SceneJson(const gs::Scene& scene, const std::vector<gs::View>& views, const gs::SplatModel& model);

// The half of the model's extent, for a scene that is nothing but a splat: its near plane follows from it.
double ExtentOf(const gs::SplatModel& model);

}  // namespace vesta::app
