// SPDX-License-Identifier: Apache-2.0
// What --show shows of views: images for files and films.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/inputs/posed_model.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/render/surface.h"

namespace vesta::app {

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
