// SPDX-License-Identifier: Apache-2.0
// Random splat models in front of random views.
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

// A view with a random pose and its principal point off the centre.
splat::PosedCamera RandomView(Random& random, int width, int height);

// How a random model looks. Lengths are in pixels of the view it is made for.
struct SceneOptions {
  std::string name = {};
  int width = 37, height = 21;
  int count = 40;
  int sh_degree = 3;
  double sigma_min = 0.7, sigma_max = 6;  // longest standard deviation
  double aspect_max = 4;                  // longest over the other two
  double opacity_min = 0.1, opacity_max = 0.9;
  double border = 0.2;   // the means may lie outside the image by this fraction of it
  double behind = 0;     // fraction of the Gaussians behind the camera
  bool extreme = false;  // sums over all Gaussians are ill-conditioned too
};
inline std::ostream& operator<<(std::ostream& os, const SceneOptions& options) { return os << options.name; }

// A model and a view. Parameters are exact in float, so both precisions use the same model.
struct Scene {
  splat::PosedCamera view;
  int count = 0, sh_degree = 0, active_sh_degree = 0;
  std::int64_t without_band[splat::kMaxShDegree] = {};  // as in ModelLayout
  std::vector<double> x;                                // layout.h
  double background[3] = {0.2, 0.5, 0.9};

  splat::ModelLayout layout() const { return {count, sh_degree, {without_band[0], without_band[1], without_band[2]}}; }
  double& At(int attribute, int i) { return x[static_cast<std::size_t>(layout().Offset(attribute) + i)]; }
  double At(int attribute, int i) const { return x[static_cast<std::size_t>(layout().Offset(attribute) + i)]; }
};

// A scene whose Gaussians are still unset.
Scene EmptyScene(const splat::PosedCamera& view, int count, int sh_degree);
// In front of the given view, whose size overrides the options, or of a random view.
Scene RandomScene(const splat::PosedCamera& view, const SceneOptions& options, Random& random);
Scene RandomScene(const SceneOptions& options, std::uint64_t seed);

// Removes the values of SH bands that the layout lacks. `values` has the layout of a model with one degree.
template <class S>
std::vector<S> RemoveMissingBands(const std::vector<S>& values, const splat::ModelLayout& layout) {
  std::vector<S> rest;
  for (int a = 0; a < splat::NumAttributes(layout.sh_degree); ++a) {
    const auto begin = values.begin() + a * layout.count;
    rest.insert(rest.end(), begin, begin + layout.Rows(a));
  }
  return rest;
}
// The inverse: inserts zeros for the SH bands that the layout lacks.
template <class S>
std::vector<S> WithZeros(const std::vector<S>& values, const splat::ModelLayout& layout) {
  std::vector<S> all(static_cast<std::size_t>(splat::NumAttributes(layout.sh_degree) * layout.count));
  for (int a = 0; a < splat::NumAttributes(layout.sh_degree); ++a) {
    std::copy_n(values.begin() + layout.Offset(a), layout.Rows(a), all.begin() + a * layout.count);
  }
  return all;
}
// The scene with band b only for its first with_band[b] Gaussians. The given scene has one degree.
Scene WithBands(const Scene& scene, const std::int64_t (&with_band)[splat::kMaxShDegree + 1]);

// The kinds of scene for tests of the operators: sizes that are not multiples of the tile, needles, splats smaller than
// a pixel or larger than the image, capped alphas, saturated pixels, means behind the camera and beyond the clamp.
std::vector<SceneOptions> SceneKinds();

// A scene rendered by a View of precision S.
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
  // The blocks of the geometry, followed by the diagonal of the colours.
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
