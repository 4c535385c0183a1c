// SPDX-License-Identifier: Apache-2.0
// Fuzzes the operators on a few Gaussians in a small view. Input bytes: a flag for wild parameters, the number of
// Gaussians, the SH degree and the image size (one byte each); the camera; the Gaussians, attribute by attribute. With
// wild parameters, any floats including NaN and infinity, the code must not crash. Others lie within the limits below,
// and results must be accurate. Runs in float, and also in double unless wild.
#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "kernels/math/quaternion.h"
#include "tests/fuzz/byte_source.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/targets.h"
#include "tests/support/adjoint.h"
#include "tests/support/random.h"
#include "tests/support/splat_scenes.h"

namespace vesta::fuzz {
namespace {

splat::PosedCamera TakeCamera(ByteSource& bytes) {
  splat::PosedCamera view{};
  view.width = 1 + bytes.Below(40), view.height = 1 + bytes.Below(40);
  double quaternion[4] = {1e-3, 0, 0, 0};
  for (double& q : quaternion) q += bytes.Take<std::int8_t>();
  RotationFromQuaternion(quaternion, view.R);
  for (double& t : view.T) t = bytes.Between(-8, 8);
  for (int i = 0; i < 3; ++i) {
    view.centre[i] = -(view.R[i] * view.T[0] + view.R[3 + i] * view.T[1] + view.R[6 + i] * view.T[2]);
  }
  // Fields of view from about 1 to 175 degrees; the principal point is up to two images away.
  view.lens.fx = view.width * std::exp2(bytes.Between(-5, 6));
  view.lens.fy = view.lens.fx * std::exp2(bytes.Between(-1, 1));
  view.lens.cx = view.width * bytes.Between(-2, 3), view.lens.cy = view.height * bytes.Between(-2, 3);
  view.near = std::exp2(bytes.Between(-10, 3));
  return view;
}

double TakeTame(ByteSource& bytes, int attribute) {
  if (attribute < splat::kLogScale) return bytes.Between(-20, 20);
  if (attribute < splat::kQuaternion) return bytes.Between(-14, 14);  // 1e-6 to 1e6
  if (attribute < splat::kOpacity) return bytes.Take<std::int8_t>() / 64.0;
  if (attribute < splat::kSh) return bytes.Between(-50, 50);
  return bytes.Between(-100, 100);
}

test::Scene TakeScene(ByteSource& bytes, bool wild) {
  test::Scene scene;
  scene.count = bytes.Below(8);
  scene.sh_degree = bytes.Below(4);
  scene.active_sh_degree = bytes.Below(scene.sh_degree + 1);
  scene.view = TakeCamera(bytes);
  const int attributes = splat::NumAttributes(scene.sh_degree);
  scene.x.reserve(static_cast<std::size_t>(Index{attributes} * scene.count));
  for (int i = 0; i < attributes * scene.count; ++i) {
    const double value =
        wild ? std::bit_cast<float>(bytes.Take<std::uint32_t>()) : TakeTame(bytes, i / std::max(scene.count, 1));
    scene.x.push_back(static_cast<float>(value));
  }
  return scene;
}

template <class S>
bool AllFinite(const std::vector<S>& values) {
  return std::all_of(values.begin(), values.end(), [](S value) { return std::isfinite(value); });
}

template <class S>
void PromiseAdjoint(test::RenderedView<S>& rendered, const std::vector<S>& v, const std::vector<S>& u, double bound) {
  const std::vector<S> Jv = rendered.ApplyJ(v), JTu = rendered.ApplyJT(u);
  Promise(AllFinite(Jv) && AllFinite(JTu), "a product that is not finite");
  const double gap = test::AdjointGap(u, Jv, JTu, v);
  Promise(gap <= bound, fmt::format("J and J^T differ by {}", gap));
}

// Compares the diagonal of J^T diag(omega) J at parameter k with J, up to rounding. If terms cancel, only rounding
// remains.
template <class S>
void PromiseSquare(test::RenderedView<S>& rendered, std::size_t k, const std::vector<S>& omega,
                   const std::vector<S>& squares) {
  constexpr double kTolerance = 1e-4, kRounding = 1e-12;
  const double square = squares[k], largest = *std::max_element(squares.begin(), squares.end());
  std::vector<S> direction(rendered.x.size());
  direction[k] = 1;
  const std::vector<S> column = rendered.ApplyJ(direction);
  double expected = 0;
  for (std::size_t p = 0; p < column.size(); ++p) {
    expected += static_cast<double>(omega[p]) * static_cast<double>(column[p]) * static_cast<double>(column[p]);
  }
  const double gap = std::abs(square - expected);
  Promise(gap <= kTolerance * expected + kRounding * largest,
          fmt::format("parameter {}: {} in the Gram matrix, {} from J", k, square, expected));
}

// If bound > 0, results must be finite and accurate; it limits the adjoint gap.
template <class S>
void RunOperators(const test::Scene& scene, std::uint64_t seed, double bound) {
  test::RenderedView<S> rendered(scene);
  test::Random random(seed);
  const std::vector<S> v = random.NormalVector<S>(scene.x.size()), u = random.NormalVector<S>(rendered.image.size());
  std::vector<S> omega = u;
  for (S& value : omega) value *= value;
  const auto count = static_cast<std::size_t>(scene.count);
  std::vector<S> blocks(count * splat::kGeometry * (splat::kGeometry + 1) / 2);
  std::vector<S> harmonics(scene.x.size() - count * splat::kSh);
  rendered.view.AddGram(rendered.model, rendered.image.data(), omega.data(), blocks.data(), harmonics.data(),
                        rendered.workspace);
  if (bound > 0) {
    Promise(AllFinite(rendered.image), "an image that is not finite");
    PromiseAdjoint(rendered, v, u, bound);
    Promise(AllFinite(blocks) && AllFinite(harmonics), "a Gram matrix that is not finite");
    std::vector<S> squares;
    for (std::size_t k = 0; k < scene.x.size(); ++k) {
      const std::size_t a = k / count, i = k % count;
      squares.push_back(a < splat::kGeometry ? blocks[(a * (a + 1) / 2 + a) * count + i]
                                             : harmonics[(a - splat::kGeometry) * count + i]);
      Promise(squares.back() >= 0, "a negative square");
    }
    // In float, entries far below the largest are rounding errors.
    if (sizeof(S) == sizeof(double) && !squares.empty()) PromiseSquare(rendered, seed % squares.size(), omega, squares);
  } else {
    rendered.ApplyJ(v), rendered.ApplyJT(u);
  }
  for (const splat::CacheFormat format : {splat::CacheFormat::kFull, splat::CacheFormat::kHalf}) {
    rendered.view.CacheJacobian(rendered.image.data(), format, rendered.workspace);
    if (bound > 0) {
      PromiseAdjoint(rendered, v, u, bound);
    } else {
      rendered.ApplyJ(v), rendered.ApplyJT(u);
    }
  }
}

}  // namespace

void FuzzOperators(std::string_view bytes) {
  ByteSource source(bytes);
  const bool wild = source.Take<std::uint8_t>() % 2 == 1;
  const test::Scene scene = TakeScene(source, wild);
  RunOperators<float>(scene, bytes.size(), wild ? 0 : 1e-2);
  if (!wild) RunOperators<double>(scene, bytes.size(), 1e-8);
}

}  // namespace vesta::fuzz
