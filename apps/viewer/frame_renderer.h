// SPDX-License-Identifier: Apache-2.0
// Pictures for pages: by the rasterizer that trains.
#pragma once

#include <array>
#include <mutex>
#include <string>
#include <vector>

#include "apps/inputs/posed_model.h"
#include "apps/viewer/frame_request.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/render/surface.h"

namespace vesta::app {

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
