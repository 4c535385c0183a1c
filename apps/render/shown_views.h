// SPDX-License-Identifier: Apache-2.0
// The views that render draws: cameras of --path, and images of the quantity --show.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/inputs/scene_and_splat.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/render/surface.h"

namespace vesta::app {

// The cameras of --path.
struct CameraPath {
  std::vector<gs::View> views;  // in the frame of the scene, without images
  std::string note;             // a line for the user, or empty
};

// Throws UsageError if flags of render are invalid or do not fit together. Reads no files.
void CheckPathFlags(const Flags& flags);

// For --path. Uses the intrinsics of the first view of the scene, or those in the file. --size changes the image size
// and crops to another aspect ratio. Throws Error (one line with the flag or the file).
CameraPath PathOfFlags(const Flags& flags, const gs::Scene& scene);

// Draws views of one model, which must outlive this object.
class ShownViews {
 public:
  ShownViews(const PosedModel& posed, Show show);

  // The files of an image of this name: the image itself, and for depth a coloured preview.
  std::vector<std::string> FilesOf(const std::string& name) const;
  // Draws the view and writes its files into the folder; with_truth: with the photograph on the right. Returns the
  // image for the video.
  gs::Image Draw(const gs::View& view, const std::string& folder, const std::string& name, bool with_truth);

  // World units per level of a depth image: 16 bits reach 32 scene extents, which is 16 median depths.
  double depth_unit() const;

 private:
  const PosedModel& posed_;
  Show show_;
  gs::Renderer colors_;
  gs::SurfaceRenderer surface_;
};

}  // namespace vesta::app
