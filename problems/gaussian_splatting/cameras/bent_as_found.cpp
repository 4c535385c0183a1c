#include "problems/gaussian_splatting/cameras/bent_as_found.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"
#include "problems/gaussian_splatting/cameras/shared_lenses.h"
#include "problems/gaussian_splatting/cameras/unbend.h"
#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "solver/numeric_diff_cost.h"

namespace vesta::gs {
namespace {

using Point = std::array<double, 2>;

// Focal lengths, principal point, four radial coefficients, two tangential ones: what of a bent camera is fitted.
constexpr int kNumbers = 10, kRadial = 4, kFitted = 4;

void TakeNumbers(const BentCamera& bent, double* x) {
  const splat::Lens& lens = bent.camera.lens;
  x = std::ranges::copy(std::array{lens.fx, lens.fy, lens.cx, lens.cy}, x).out;
  x = std::copy_n(bent.distortion.radial.begin(), kFitted, x);
  std::ranges::copy(bent.distortion.tangential, x);
}

BentCamera WithNumbers(const BentCamera& given, const double* x) {
  BentCamera bent = given;
  bent.camera.lens = {x[0], x[1], x[2], x[3]};
  // The fourth of a lens that is no fisheye is of another kind (distortion.h), and stays.
  std::copy_n(x + kRadial, given.distortion.is_fisheye ? kFitted : kFitted - 1, bent.distortion.radial.begin());
  if (!given.distortion.is_fisheye) std::copy_n(x + kRadial + kFitted, 2, bent.distortion.tangential.begin());
  return bent;
}

// Where the photograph shows a direction.
Point PixelOf(const BentCamera& bent, const Point& direction) {
  const splat::Lens& lens = bent.camera.lens;
  const Point at = Distort(bent.distortion, direction[0], direction[1]);
  return {lens.fx * at[0] + lens.cx, lens.fy * at[1] + lens.cy};
}

// Where in the pinhole's photograph as given, in focal lengths, something is that the lens as found sees there.
Point InGiven(const Camera& pinhole, const LensChange& found, const Point& direction) {
  const splat::Lens &given = pinhole.lens, now = found.Of(given);
  const double x = (now.fx * direction[0] + now.cx - given.cx) / given.fx,
               y = (now.fy * direction[1] + now.cy - given.cy) / given.fy,
               factor = BendFactor(found.radial, x * x + y * y);
  return {factor * x, factor * y};
}

struct PixelApart {
  BentCamera given;
  Point direction, pixel;
  bool operator()(const double* x, double* residual) const {
    const Point at = PixelOf(WithNumbers(given, x), direction);
    for (std::size_t k = 0; k < 2; ++k) residual[k] = at[k] - pixel[k];
    return true;
  }
};

}  // namespace

BentFit FitBent(const BentCamera& bent, const Camera& pinhole, const LensChange& found) {
  if (found.is_none()) return {bent};
  const splat::Lens now = found.Of(pinhole.lens);
  BlockProblem problem;
  const int block = problem.AddParameterBlock(kNumbers);
  std::vector<PixelApart> pixels;
  constexpr int kPlaces = 24;  // across and down the image
  for (int row = 0; row <= kPlaces; ++row) {
    for (int column = 0; column <= kPlaces; ++column) {
      const Point direction{(1.0 * pinhole.width * column / kPlaces - now.cx) / now.fx,
                            (1.0 * pinhole.height * row / kPlaces - now.cy) / now.fy};
      pixels.push_back({bent, direction, PixelOf(bent, InGiven(pinhole, found, direction))});
      problem.AddResidualBlock(std::make_shared<NumericDiffCost<PixelApart, 2, kNumbers>>(pixels.back()), nullptr,
                               {block});
    }
  }
  HostBuffer<double> x(kNumbers);
  TakeNumbers(bent, x.data());
  LmOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-12, options.parameter_tolerance = 0;  // coefficients are small beside focal lengths
  CpuBackend<double> backend;
  SolveLm(options, backend, problem, x);
  BentFit fit{WithNumbers(bent, x.data())};
  for (const PixelApart& pixel : pixels) {
    double residual[2];
    pixel(x.data(), residual);
    fit.most_pixels = std::max(fit.most_pixels, std::hypot(residual[0], residual[1]));
  }
  return fit;
}

double BendAsFound(const Scene& scene, const std::vector<ViewUnknowns>& found, std::vector<View>* views) {
  const std::vector<LensChange> lenses = LensesOf(scene, found);
  double most_pixels = 0;
  for (std::size_t v = 0; v < views->size(); ++v) {
    const View& given = scene.views[v];
    if (!given.bent) continue;
    // Most views share a lens.
    const auto same = [&](std::size_t other) {
      return ShareALens(scene.views[other], given) && lenses[other] == lenses[v];
    };
    std::size_t first = 0;
    while (!same(first)) ++first;
    if (first < v) {
      (*views)[v].bent = (*views)[first].bent;
      continue;
    }
    const BentFit fit = FitBent(*given.bent, given.camera, lenses[v]);
    (*views)[v].bent = fit.camera;
    most_pixels = std::max(most_pixels, fit.most_pixels);
  }
  return most_pixels;
}

}  // namespace vesta::gs
