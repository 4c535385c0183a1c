// SPDX-License-Identifier: Apache-2.0
// Images (frames) for the viewer's page: parses the requests of the page, and renders the requested frames with the
// same rasteriser as the training.
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

// The quantities that a frame can show.
enum class FrameKind { kRender, kTruth, kDifference, kDepth, kMedianDepth, kNormals, kCount, kRemovalCost, kCoverage };

// Whether the frame shows one value per Gaussian (gaussian_values.h).
constexpr bool ShowsValues(FrameKind kind) { return kind == FrameKind::kRemovalCost || kind == FrameKind::kCoverage; }

struct FrameRequest {
  FrameKind kind = FrameKind::kRender;
  gs::View view;                     // camera and pose; no image
  std::optional<std::size_t> photo;  // index in Scene::views for the camera of a photograph
};

// Parses the parameters of a request for a frame:
//   kind           render, truth (photograph), difference of the two, depth, median_depth, normals, count (splats per
//                  tile), removal_cost or coverage (one value for each Gaussian)
//   width, height  image size in pixels, 16 to 4096 each
//   photo          index in Scene::views of the camera to use; or instead, these three:
//   position       x,y,z of the camera, in the scene's frame
//   rotation       quaternion w,x,y,z, camera to world, any length but zero; axes x right, y down, z forward
//   focal          focal length in image heights, 0.05 to 50
// truth and difference need `photo`. For these kinds, a width or height above the photograph's is reduced to the
// photograph's. removal_cost and coverage need a scene with training views. moved: views of the scene with refined
// cameras; empty: cameras are not refined. Throws Error (one line with the parameter) for missing or invalid
// parameters.
FrameRequest ParseFrameRequest(const HttpQuery& query, const gs::Scene& scene, const std::vector<gs::View>& moved = {});

// Renders frames. Thread-safe.
class FrameRenderer {
 public:
  // FrameKind::kCount: tiles of 16 x 16 pixels with this number of splats or more have the brightest colour.
  static constexpr int kManySplats = 1000;

  // The scene must outlive this object. background: 0..1.
  FrameRenderer(const gs::Scene& scene, const std::array<float, 3>& background)
      : scene_(scene), background_(ToDouble(background)) {}

  // Returns a JPEG. model: in the frame of the scene. scale_positions: for a frame of values per Gaussian, the position
  // of each Gaussian on the colour scale, 0..1; else null.
  std::string Jpeg(const gs::SplatModel& model, const FrameRequest& request,
                   const std::vector<float>* scale_positions = nullptr);

 private:
  gs::Image Picture(const gs::SplatModel& model, const FrameRequest& request,
                    const std::vector<float>* scale_positions);
  // These functions draw splats_, which Picture has built for the model and camera.
  gs::Image DepthImage(const splat::Model<float>& model, gs::DepthKind kind);
  gs::Image ValueImage(const std::vector<float>& scale_positions);
  gs::Image CountImage() const;

  const gs::Scene& scene_;
  std::array<double, 3> background_;
  std::mutex mutex_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

}  // namespace vesta::app
