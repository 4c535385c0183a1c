// SPDX-License-Identifier: Apache-2.0
// What a page asks a picture of.
#pragma once

#include <optional>
#include <vector>

#include "apps/viewer/http_server.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

enum class FrameKind { kRender, kTruth, kDifference, kDepth, kMedianDepth, kNormals, kCount, kWorth, kSupport };

// Whether it shows what the Gaussians are to the training views (gaussian_values.h).
constexpr bool ShowsValues(FrameKind kind) { return kind == FrameKind::kWorth || kind == FrameKind::kSupport; }

struct FrameRequest {
  FrameKind kind = FrameKind::kRender;
  gs::View view;                     // camera and pose; no image
  std::optional<std::size_t> photo;  // whose camera that is, of the scene's views
};

// From numbers as text:
//   kind           render, truth (the photograph), difference of both, depth, median_depth, normals, count (of
//                  splats), worth or support (of Gaussians, to the training views)
//   width, height  pixels of the picture, 16 to 4096 each
//   photo          number of the scene's view whose camera it is, or
//   position       x,y,z of the camera, in the scene's frame
//   rotation       w,x,y,z, camera to world; of any length but zero; axes x right, y down, z forward
//   focal          of the lens, in heights of the picture, 0.05 to 50
// Throws Error, one line naming what is missing or wrong. Truth and difference need a photo, whose pixels they have at
// most; worth and support need a scene.
// moved: the scene's views where their cameras stand now; empty: where the scene has them.
FrameRequest ParseFrameRequest(const HttpQuery& query, const gs::Scene& scene, const std::vector<gs::View>& moved = {});

}  // namespace vesta::app
