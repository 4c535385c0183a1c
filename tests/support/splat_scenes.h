// SPDX-License-Identifier: Apache-2.0
// Random splats in front of random cameras.
#pragma once

#include <algorithm>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "tests/support/random.h"

namespace vesta::test {

// A camera with a random pose and a principal point off the centre of the image.
splat::PosedCamera RandomView(Random& random, int width, int height);

// Lengths are in pixels of the image.
struct SceneOptions {
  std::string name = {};
  int width = 37, height = 21;
  int count = 40;
  int sh_degree = 3;
  double sigma_min = 0.7, sigma_max = 6;  // of the largest standard deviation
  double aspect_max = 4;                  // of the largest standard deviation to the others
  double opacity_min = 0.1, opacity_max = 0.9;
  double border = 0.2;  // means may lie outside by this fraction of the image size
  double behind = 0;    // fraction of the Gaussians
  // Sums over all Gaussians are ill-conditioned, so that tests need larger tolerances.
  bool extreme = false;
};
inline std::ostream& operator<<(std::ostream& os, const SceneOptions& options) { return os << options.name; }

// All parameters are representable in float, so float and double use the same model.
struct Scene {
  splat::PosedCamera view;
  int count = 0, sh_degree = 0, active_sh_degree = 0;
  std::int64_t without_band[splat::kMaxShDegree] = {};  // as in ModelLayout
  std::vector<double> x;                                // in the layout of formulas/layout.h

  double background[3] = {0.2, 0.5, 0.9};

  splat::ModelLayout layout() const { return {count, sh_degree, {without_band[0], without_band[1], without_band[2]}}; }
  double& At(int attribute, int i) { return x[static_cast<std::size_t>(layout().Offset(attribute) + i)]; }
  double At(int attribute, int i) const { return x[static_cast<std::size_t>(layout().Offset(attribute) + i)]; }
};

// `count` Gaussians whose parameters are zero.
Scene EmptyScene(const splat::PosedCamera& view, int count, int sh_degree);
// A random scene in front of this camera, whose image size replaces the size in the options, or of a random one.
Scene RandomScene(const splat::PosedCamera& view, const SceneOptions& options, Random& random);
Scene RandomScene(const SceneOptions& options, std::uint64_t seed);

// `values` has all SH bands for all Gaussians; removes the bands that Gaussians lack in `layout`.
template <class S>
std::vector<S> RemoveMissingBands(const std::vector<S>& values, const splat::ModelLayout& layout) {
  std::vector<S> rest;
  for (int a = 0; a < splat::NumAttributes(layout.sh_degree); ++a) {
    const auto begin = values.begin() + a * layout.count;
    rest.insert(rest.end(), begin, begin + layout.Rows(a));
  }
  return rest;
}
// The inverse: inserts zeros for the missing bands.
template <class S>
std::vector<S> WithZeros(const std::vector<S>& values, const splat::ModelLayout& layout) {
  std::vector<S> all(static_cast<std::size_t>(splat::NumAttributes(layout.sh_degree) * layout.count));
  for (int a = 0; a < splat::NumAttributes(layout.sh_degree); ++a) {
    std::copy_n(values.begin() + layout.Offset(a), layout.Rows(a), all.begin() + a * layout.count);
  }
  return all;
}
// With SH band b only for the first with_band[b] Gaussians. In `scene`, all have all bands.
Scene WithBands(const Scene& scene, const std::int64_t (&with_band)[splat::kMaxShDegree + 1]);

// Scenes for tests of J v, J^T u and the Gram matrices: image sizes that are no multiples of the tile, needles, splats
// smaller than a pixel or larger than the image, alphas at their maximum, opaque pixels, and means behind the camera or
// so far outside the image that their Jacobian is clamped.
std::vector<SceneOptions> SceneKinds();

// Rendered by SplatView in precision S, float or double, with products with its Jacobian J.
template <class S>
struct RenderedView {
  using Scalar = S;
  std::vector<S> x;
  splat::Model<S> model;
  splat::SplatView<S> view;
  splat::ViewWorkspace<S> workspace;
  std::vector<S> image;

  explicit RenderedView(const Scene& scene)
      : x(scene.x.begin(), scene.x.end()), model{x.data(), scene.layout(), scene.active_sh_degree} {
    view.Build(model, scene.view, scene.background, workspace);
    image.resize(static_cast<std::size_t>(3 * view.num_pixels()));
    view.Render(image.data());
  }
  std::vector<S> ApplyJ(const std::vector<S>& dx) {
    std::vector<S> d_image(image.size());
    view.ApplyJ(model, dx.data(), d_image.data(), workspace);
    return d_image;
  }
  std::vector<S> ApplyJT(const std::vector<S>& u) {
    std::vector<S> g(x.size());
    view.AddJT(model, image.data(), u.data(), g.data(), workspace);
    return g;
  }
  // J^T diag(omega) J: the blocks of the geometry, then the diagonal of the colours (AddGram).
  std::vector<S> Gram(const std::vector<S>& omega) {
    const auto blocks = static_cast<std::size_t>(splat::kGeometry * (splat::kGeometry + 1) / 2 * model.count);
    std::vector<S> gram(blocks + x.size() - static_cast<std::size_t>(splat::kSh * model.count));
    view.AddGram(model, image.data(), omega.data(), gram.data(), gram.data() + blocks, workspace);
    return gram;
  }
  Index num_splats() const { return view.num_splats(); }
  std::vector<std::int32_t> rank_of() const { return {view.rank_of().begin(), view.rank_of().end()}; }
};

}  // namespace vesta::test
