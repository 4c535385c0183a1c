// SPDX-License-Identifier: Apache-2.0
// Depth and normals of a model in a view, and their colours.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// What stands in front of a camera: how far away it is, and which way it faces. Both are blended from the Gaussians of
// a view with the weights of its colours.
//
// kMedian: the depth of the Gaussian at which the transmittance falls below one half. It is always that of something,
// but jumps where the mean slides.
enum class DepthKind { kMean, kMedian };

// Expected depth along the optical axis, world units: the mean, by weight, of where the ray of the pixel passes the
// middle of each Gaussian. Where something is half transparent, and at silhouettes, it lies between what is in front
// and what is behind. (The depths of the Gaussians' centres would make surfaces that are seen obliquely too near, by
// percents: of two that overlap the nearer one is in front in the other's pixels too.)
struct DepthImage {
  int width = 0, height = 0;
  std::vector<float> depth;  // row by row; 0 where less than half of the colour is the Gaussians'
};

// Unit normals in the axes x right, y up, z towards the camera.
struct NormalImage {
  int width = 0, height = 0;
  std::vector<float> normals;  // planes of x, y and z; 0 where less than half of the colour is the Gaussians'
};

// Of a view that Build has made of the model, whatever else is rendered of it; no Jacobian may be cached. Each takes
// about twice as long as Render.
DepthImage DepthOf(const splat::SplatView<float>& view, const splat::Model<float>& model,
                   splat::ViewWorkspace<float>& workspace, DepthKind kind = DepthKind::kMean);
// A Gaussian's normal is its shortest axis, turned to the camera. It counts by 1 - shortest / middle deviation: discs
// have normals, balls and needles have none.
NormalImage NormalsOf(const splat::SplatView<float>& view, const splat::Model<float>& model,
                      splat::ViewWorkspace<float>& workspace);

// Of models and views; keeps its working memory between calls.
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

// From near, yellow, to far, violet; black where there is no depth. In the middle of the scale is the depth
// `middle` > 0: colours are by middle / (middle + depth), so that they mean the same in all images.
Image DepthColors(const DepthImage& depth, double middle);

// As normal maps have them: red, green and blue are x, y and z from -1 to 1; what faces the camera is light blue. Black
// where there is no normal.
Image NormalColors(const NormalImage& normals);

}  // namespace vesta::gs
