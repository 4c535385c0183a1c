#include "kernels/gaussian_splatting/lens_jacobian.h"

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/project.h"

namespace vesta::splat {
namespace {

constexpr Index kGrain = 1024;  // splats

// What a splat's whitened tangent is made of, as the lens changes: rows of kLambda numbers, the others are zero.
struct LensRows {
  double w[kLensTangent][kLambda] = {};

  template <class S>
  LensRows(const Splat<S>& splat, const Lens& lens) {
    const SplatShape<double> shape = {double(splat.u), double(splat.v), double(splat.r), double(splat.s),
                                      double(splat.beta)};
    // The screen covariance [A B; B C], from the factor of its inverse (types.h).
    const double C = kWhitening * kWhitening / (shape.s * shape.s), B = -shape.beta * C;
    const double det_by_C = kWhitening * kWhitening / (shape.r * shape.r), det = det_by_C * C, A = det_by_C + B * B / C;
    const auto set = [&](int k, double du, double dv, double dA, double dB, double dC) {
      const double d_det = dA * C + A * dC - 2 * B * dB;
      const SplatShape<double> d = {du, dv, shape.r * (dC / C - d_det / det) / 2, -shape.s * dC / (2 * C),
                                    (B * dC / C - dB) / C};
      WhitenTangent(shape, d, w[k]);
    };
    set(0, shape.u - lens.cx, 0, 2 * (A - kLowPass), B, 0);
    set(1, 0, shape.v - lens.cy, 0, B, 2 * (C - kLowPass));
    set(2, lens.fx, 0, 0, 0, 0);
    set(3, 0, lens.fy, 0, 0, 0);
  }
};

}  // namespace

template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace) {
  HostBuffer<SplatTangent<S>>& tangents = workspace.splat_sums;
  if (tangents.size() < view.num_splats()) tangents.ResizeForOverwrite(view.num_splats());
  ParallelFor(view.num_splats(), kGrain, [&](Index rank) {
    const LensRows rows(view.splats()[rank], view.camera().lens);
    SplatTangent<S>& tangent = tangents[rank] = {};
    for (int i = 0; i < kLambda; ++i) {
      double sum = 0;
      for (int k = 0; k < kLensTangent; ++k) sum += rows.w[k][i] * delta.v[k];
      tangent.w[i] = static_cast<S>(sum);
    }
  });
  view.ApplyRasterJ(tangents.data(), d_image);
}

template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents) {
  return ParallelSum<LensTangent>(view.num_splats(), kGrain, [&](Index begin, Index end) {
    LensTangent sum;
    for (Index rank = begin; rank < end; ++rank) {
      const LensRows rows(view.splats()[rank], view.camera().lens);
      for (int k = 0; k < kLensTangent; ++k) {
        for (int i = 0; i < kLambda; ++i) sum.v[k] += rows.w[k][i] * static_cast<double>(cotangents[rank].w[i]);
      }
    }
    return sum;
  });
}

template void ApplyLensJ(const SplatView<float>&, const LensTangent&, float*, ViewWorkspace<float>&);
template void ApplyLensJ(const SplatView<double>&, const LensTangent&, double*, ViewWorkspace<double>&);
template LensTangent LensCotangent(const SplatView<float>&, const SplatTangent<float>*);
template LensTangent LensCotangent(const SplatView<double>&, const SplatTangent<double>*);

}  // namespace vesta::splat
