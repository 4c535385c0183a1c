// SPDX-License-Identifier: Apache-2.0
// The views that render draws: the cameras of --path, and the images that --show chooses.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/inputs/scene_and_splat.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/render/surface.h"

namespace vesta::app {

// The cameras that --path names.
struct CameraPath {
  std::vector<gs::View> views;  // in the frame of the scene, without images
  std::string note;             // a line for the user, or none
};

// Throws UsageError where flags of render do not go together or are none, before anything is read.
void CheckPathFlags(const Flags& flags);

// With --path. Cameras are that of the scene's first view, or those of the file, each of --size where that is given:
// then the middle of what it sees. Throws Error, one line with flag or file.
CameraPath PathOfFlags(const Flags& flags, const gs::Scene& scene);

// Draws views of one model, which must outlive this.
class ShownViews {
 public:
  ShownViews(const PosedModel& posed, Show show);

  // The files of a view whose image is to have this name: that, and of depth a preview in colours too.
  std::vector<std::string> FilesOf(const std::string& name) const;
  // Writes them into the folder; with_truth: beside the photograph. Returns what a film shows.
  gs::Image Draw(const gs::View& view, const std::string& folder, const std::string& name, bool with_truth);

  // World units in a level of depth files: so far apart that 16 bits reach 32 extents of the scene, 16 median depths.
  double depth_unit() const;

 private:
  const PosedModel& posed_;
  Show show_;
  gs::Renderer colors_;
  gs::SurfaceRenderer surface_;
};

}  // namespace vesta::app
