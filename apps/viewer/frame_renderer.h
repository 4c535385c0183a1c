// SPDX-License-Identifier: Apache-2.0
// Pictures for pages: the requests for them, and their rendering by the rasterizer that trains.
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

// What a page asks a picture of.
enum class FrameKind { kRender, kTruth, kDifference, kDepth, kMedianDepth, kNormals, kCount, kRemovalCost, kCoverage };

// Whether it shows what the Gaussians are to the training views (gaussian_values.h).
constexpr bool ShowsValues(FrameKind kind) { return kind == FrameKind::kRemovalCost || kind == FrameKind::kCoverage; }

struct FrameRequest {
  FrameKind kind = FrameKind::kRender;
  gs::View view;                     // camera and pose; no image
  std::optional<std::size_t> photo;  // whose camera that is, of the scene's views
};

// From numbers as text:
//   kind           render, truth (the photograph), difference of both, depth, median_depth, normals, count (of
//                  splats), removal_cost or coverage (of Gaussians, to the training views)
//   width, height  pixels of the picture, 16 to 4096 each
//   photo          number of the scene's view whose camera it is, or
//   position       x,y,z of the camera, in the scene's frame
//   rotation       w,x,y,z, camera to world; of any length but zero; axes x right, y down, z forward
//   focal          of the lens, in heights of the picture, 0.05 to 50
// Throws Error, one line naming what is missing or wrong. Truth and difference need a photo, whose pixels they have at
// most; removal_cost and coverage need a scene.
// moved: the scene's views where their cameras stand now; empty: where the scene has them.
FrameRequest ParseFrameRequest(const HttpQuery& query, const gs::Scene& scene, const std::vector<gs::View>& moved = {});

// Pictures for pages: by the rasterizer that trains.
class FrameRenderer {
 public:
  // The brightest colour of FrameKind::kCount: so many splats whose support meets a tile of 16 x 16 pixels.
  static constexpr int kManySplats = 1000;

  // The scene must outlive it. background: behind all Gaussians, 0..1.
  FrameRenderer(const gs::Scene& scene, const std::array<float, 3>& background)
      : scene_(scene), background_(ToDouble(background)) {}

  // The bytes of a JPEG. model: in the scene's frame. May be called by several threads, which wait
  // for each other. places: of the kinds that show values, those of the model's Gaussians on a scale of colours.
  std::string Jpeg(const gs::SplatModel& model, const FrameRequest& request,
                   const std::vector<float>* places = nullptr);

 private:
  gs::Image Picture(const gs::SplatModel& model, const FrameRequest& request, const std::vector<float>* places);
  // Of what is built.
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
