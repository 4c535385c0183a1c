// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/frame_renderer.h"

#include <algorithm>

#include "apps/report/error_map.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/io/images/image_file.h"
#include "splatting/render/look.h"
#include "splatting/render/surface.h"

namespace vesta::app {

std::string FrameRenderer::Jpeg(const gs::SplatModel& model, const FrameRequest& request,
                                const std::vector<float>* places) {
  constexpr int kQuality = 85;
  gs::Image picture;
  {
    const std::lock_guard lock(mutex_);
    picture = Picture(model, request, places);
  }
  return gs::EncodeJpeg(picture, kQuality);
}

gs::Image FrameRenderer::Picture(const gs::SplatModel& model, const FrameRequest& request,
                                 const std::vector<float>* places) {
  const gs::Camera& camera = request.view.camera;
  gs::Image truth;
  if (request.kind == FrameKind::kTruth || request.kind == FrameKind::kDifference) {
    const gs::View& photo = scene_.views[*request.photo];
    // Of a store nothing is kept of it: its order is that of the training.
    truth = gs::ResizeArea(photo.stored ? *photo.stored->Read() : photo.image, camera.width, camera.height);
  }
  if (request.kind == FrameKind::kTruth) return truth;
  const splat::Model<float> kernel_model = gs::ToKernelModel(model);
  splat::PosedCamera posed = gs::ToPosedCamera(request.view, gs::NearPlane(scene_));
  // Cameras that the page makes have none of their own, nor has a splat that is being trained.
  posed.low_pass = scene_.views.empty() ? model.low_pass : scene_.views.front().camera.low_pass;
  splats_.Build(kernel_model, posed, background_.data(), workspace_);
  switch (request.kind) {
    case FrameKind::kCount:
      return CountImage();
    case FrameKind::kDepth:
      return DepthImage(kernel_model, gs::DepthKind::kMean);
    case FrameKind::kMedianDepth:
      return DepthImage(kernel_model, gs::DepthKind::kMedian);
    case FrameKind::kNormals:
      return gs::NormalColors(gs::NormalsOf(splats_, kernel_model, workspace_));
    case FrameKind::kWorth:
    case FrameKind::kSupport:
      return ValueImage(*places);
    default:
      break;
  }
  gs::Image image(camera.width, camera.height);
  splats_.Render(image.rgb.data());
  return request.kind == FrameKind::kDifference ? ErrorMap(image, truth) : image;
}

gs::Image FrameRenderer::DepthImage(const splat::Model<float>& model, gs::DepthKind kind) {
  return gs::DepthColors(gs::DepthOf(splats_, model, workspace_, kind), 2 * scene_.extent);
}

gs::Image FrameRenderer::ValueImage(const std::vector<float>& places) {
  gs::Image image(splats_.camera().width, splats_.camera().height);
  image.rgb = gs::Blend(splats_, workspace_,
                        [&](Index i) { return gs::OnScale(gs::kVioletToYellow, places[static_cast<std::size_t>(i)]); });
  return image;
}

gs::Image FrameRenderer::CountImage() const {
  const splat::TileLists<float> lists = splats_.Lists();
  gs::Image image(lists.width, lists.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int tile = y / splat::kTileSize * lists.tiles_x + x / splat::kTileSize;
      const auto count = static_cast<float>(lists.tile_begin[tile + 1] - lists.tile_begin[tile]);
      const std::array<float, 3> color = HeatColor(std::min(count / kManySplats, 1.0f));
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      for (int c = 0; c < 3; ++c) image.plane(c)[pixel] = color[static_cast<std::size_t>(c)];
    }
  }
  return image;
}

}  // namespace vesta::app
