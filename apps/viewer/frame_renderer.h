// SPDX-License-Identifier: Apache-2.0
// Images for the viewer's page: parses requests and renders them with the rasteriser of the training.
#pragma once

#include <array>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/inputs/scene_and_splat.h"
#include "apps/viewer/http_server.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/render/surface.h"

namespace vesta::app {

// The display modes of the page.
enum class FrameKind { kRender, kTruth, kDifference, kDepth, kMedianDepth, kNormals, kCount, kRemovalCost, kCoverage };

// Whether the mode shows a value per Gaussian (gaussian_values.h).
constexpr bool ShowsValues(FrameKind kind) { return kind == FrameKind::kRemovalCost || kind == FrameKind::kCoverage; }

struct FrameRequest {
  FrameKind kind = FrameKind::kRender;
  gs::View view;                     // camera and pose; no image
  std::optional<std::size_t> photo;  // index of the scene's view whose camera this is
};

// Parses the parameters of a frame:
//   kind           render, truth (photograph), difference of the two, depth, median_depth, normals, count (splats per
//                  tile), removal_cost or coverage (one value for each Gaussian)
//   width, height  image size in pixels, 16 to 4096 each
//   photo          index of the scene's view whose camera to use, or these three:
//   position       x,y,z of the camera, in the scene's frame
//   rotation       quaternion w,x,y,z, camera to world, any length but zero; axes x right, y down, z forward
//   focal          focal length in image heights, 0.05 to 50
// Throws Error (one line with the parameter). truth and difference need a photo, which limits their size;
// removal_cost and coverage need a scene. moved: the views of the scene with refined cameras; empty: not refined.
FrameRequest ParseFrameRequest(const HttpQuery& query, const gs::Scene& scene, const std::vector<gs::View>& moved = {});

// Renders the images. Thread-safe.
class FrameRenderer {
 public:
  // The number of splats in a tile of 16 x 16 pixels with the brightest colour in FrameKind::kCount.
  static constexpr int kManySplats = 1000;

  // The scene must outlive this object. background: colour, 0..1.
  FrameRenderer(const gs::Scene& scene, const std::array<float, 3>& background)
      : scene_(scene), background_(ToDouble(background)) {}

  // Returns a JPEG. model: in the frame of the scene. Several threads may call it; they wait for each other. places:
  // for the modes with a value per Gaussian, positions on the colour scale, 0..1.
  std::string Jpeg(const gs::SplatModel& model, const FrameRequest& request,
                   const std::vector<float>* places = nullptr);

 private:
  gs::Image Picture(const gs::SplatModel& model, const FrameRequest& request, const std::vector<float>* places);
  // Draw splats_, which must be built.
  gs::Image DepthImage(const splat::Model<float>& model, gs::DepthKind kind);
  gs::Image ValueImage(const std::vector<float>& places);
  gs::Image CountImage() const;

  const gs::Scene& scene_;
  std::array<double, 3> background_;
  std::mutex mutex_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

}  // namespace vesta::app
