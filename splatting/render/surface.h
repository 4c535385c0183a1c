// SPDX-License-Identifier: Apache-2.0
// Depth and normal maps of a model in a view, and their colours.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// kMean: mean depth, with the weights that blend the colours. kMedian: depth of the Gaussian at which the transmittance
// falls below one half. The median never lies between two surfaces, but it jumps from Gaussian to Gaussian where the
// mean is smooth.
enum class DepthKind { kMean, kMedian };

// Depth along the optical axis in world units. A Gaussian's depth in a pixel is the depth of its maximum density along
// the pixel's ray. At silhouettes and half-transparent surfaces, the mean depth lies between foreground and background.
// (The depths of the Gaussians' centres would place oblique surfaces some percent too near: where two Gaussians
// overlap, the nearer one has the larger weight, also in the pixels of the other.)
struct DepthImage {
  int width = 0, height = 0;
  std::vector<float> depth;  // row by row; 0 where the Gaussians' opacity is below one half
};

// Unit normals in the axes x right, y up, z towards the camera.
struct NormalImage {
  int width = 0, height = 0;
  std::vector<float> normals;  // planes of x, y and z; 0 where the Gaussians' opacity is below one half
};

// `view` must have been built (SplatView::Build) from the model, without a cached Jacobian. Takes about twice the time
// of Render.
DepthImage DepthOf(const splat::SplatView<float>& view, const splat::Model<float>& model,
                   splat::ViewWorkspace<float>& workspace, DepthKind kind = DepthKind::kMean);
// A Gaussian's normal is its shortest axis, pointing to the camera. Its weight is 1 - shortest / middle standard
// deviation, so discs have normals, and balls and needles have none.
NormalImage NormalsOf(const splat::SplatView<float>& view, const splat::Model<float>& model,
                      splat::ViewWorkspace<float>& workspace);

// Keeps its work memory between calls.
class SurfaceRenderer {
 public:
  // Distance of the near plane, world units.
  explicit SurfaceRenderer(double near) : near_(near) {}

  DepthImage Depth(const SplatModel& model, const View& view, DepthKind kind = DepthKind::kMean);
  NormalImage Normals(const SplatModel& model, const View& view);

 private:
  splat::Model<float> Build(const SplatModel& model, const View& view);

  double near_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

// Colours from yellow (near) to violet (far); black: no depth. The position on the colour scale is middle /
// (middle + depth): one half at the depth `middle` > 0. Images with the same `middle` have comparable colours.
Image DepthColors(const DepthImage& depth, double middle);

// Colours of normal maps: red, green and blue are x, y and z from -1 to 1. Surfaces that face the camera are light
// blue; black: no normal.
Image NormalColors(const NormalImage& normals);

}  // namespace vesta::gs
