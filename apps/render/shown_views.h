// SPDX-License-Identifier: Apache-2.0
// For `vesta render`: the cameras of --path, and images of the quantity of --show.
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
  std::string note;             // one line for the user; empty: none
};

// Throws UsageError if --path, --size, --frames, --film, --fps, --truth or their combination is invalid. Reads no
// files.
void CheckPathFlags(const Flags& flags);

// Intrinsics come from the file of --path, else from the first view of the scene. --size scales the images, and crops
// them if the aspect ratio differs. Throws Error (one line with the flag or the file).
CameraPath PathOfFlags(const Flags& flags, const gs::Scene& scene);

// Draws a model from given views. `posed` must outlive this object.
class ShownViews {
 public:
  ShownViews(const PosedModel& posed, Show show);

  // The files that Draw writes: the image, and for depth also a coloured preview.
  std::vector<std::string> FilesOf(const std::string& name) const;
  // Draws the view and writes its files into the folder. with_truth: adds the photograph on the right. Returns the
  // image for the video; for depth the preview.
  gs::Image Draw(const gs::View& view, const std::string& folder, const std::string& name, bool with_truth);

  // World units per level of a depth image. Its 65,536 levels reach to 32 times Scene::extent.
  double depth_unit() const;

 private:
  const PosedModel& posed_;
  Show show_;
  gs::Renderer colors_;
  gs::SurfaceRenderer surface_;
};

}  // namespace vesta::app
