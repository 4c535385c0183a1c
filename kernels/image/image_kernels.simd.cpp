#include "kernels/image/image_kernels.h"

#include "kernels/image/photometric_formula.h"
#include "kernels/image/row_blur.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

// A sum of one row: vectors in S, the lanes in double.
template <class S>
struct RowSum {
  using V = xsimd::batch<S>;
  V lanes = V(S(0));

  // The total; begins the next row.
  double Take() {
    alignas(64) S lane[V::size];
    lanes.store_aligned(lane);
    double total = 0.0;
    for (const S value : lane) total += static_cast<double>(value);
    lanes = V(S(0));
    return total;
  }
};

template <class S>
void Windows(const RowRange<S>& rows, const WindowArgs<S>& args) {
  using V = xsimd::batch<S>;
  const V floor(args.floor);
  RowSum<S> absolute, floored, dissimilarity;
  const auto sums_and_squares = [&](Index i, auto access) {
    const V x = access.Load(args.rendered + i), y = access.Load(args.truth + i);
    const V u = x + y, e = x - y;
    return Fields<4, V>{{u, e, u * u, e * e}};
  };
  const auto measure = [&](Index i, auto access, const Fields<4, V>& blurred) {
    const SsimWindow<V> window(blurred.f[0], blurred.f[1], blurred.f[2], blurred.f[3]);
    const FlooredAbsolute<V> l1(access.Load(args.rendered + i) - access.Load(args.truth + i), floor);
    const V value = window.Dissimilarity();
    absolute.lanes += access.Used(l1.absolute);
    floored.lanes += access.Used(l1.value);
    dissimilarity.lanes += access.Used(value);
    if (args.dissimilarity != nullptr) access.Store(args.dissimilarity + i, value);
    if (args.p == nullptr) return;
    const SsimSlopes<V> slopes(window);
    access.Store(args.p + i, slopes.p);
    access.Store(args.q + i, slopes.q);
    access.Store(args.s + i, slopes.s);
    if (args.curvature != nullptr) access.Store(args.curvature + i, SsimWindowCurvature(window, slopes));
  };
  BlurRows<4>(rows, sums_and_squares, measure, [&](int row) {
    double* sums = args.row_sums + 3 * row;
    sums[0] = absolute.Take();
    sums[1] = floored.Take();
    sums[2] = dissimilarity.Take();
  });
}

template <class S>
void Gradient(const RowRange<S>& rows, const GradientArgs<S>& args) {
  using V = xsimd::batch<S>;
  const V l1(args.l1), ssim(args.ssim), floor(args.floor);
  const auto slopes = [&](Index i, auto access) {
    return Fields<3, V>{{access.Load(args.p + i), access.Load(args.q + i), access.Load(args.s + i)}};
  };
  const auto combine = [&](Index i, auto access, const Fields<3, V>& blurred) {
    const V x = access.Load(args.rendered + i);
    const V e = x - access.Load(args.truth + i);
    const FlooredAbsolute<V> absolute(e, floor);
    const V by_ssim = SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]);
    access.Store(args.gradient + i, Fma(ssim, by_ssim, l1 * absolute.slope));
    if (args.diagonal != nullptr) {
      access.Store(args.diagonal + i, Fma(ssim, blurred.f[2], l1 * absolute.curvature));
    }
  };
  BlurRows<3>(rows, slopes, combine);
}

template <class S>
void Tangent(const RowRange<S>& rows, const JacobianArgs<S>& args) {
  using V = xsimd::batch<S>;
  const auto products = [&](Index i, auto access) {
    const V v = access.Load(args.in + i), x = access.Load(args.rendered + i);
    return Fields<3, V>{{v, x * v, (x - access.Load(args.truth + i)) * v}};
  };
  const auto combine = [&](Index i, auto access, const Fields<3, V>& blurred) {
    access.Store(args.out + i, SsimTangent(access.Load(args.p + i), access.Load(args.q + i), access.Load(args.s + i),
                                           blurred.f[0], blurred.f[1], blurred.f[2]));
  };
  BlurRows<3>(rows, products, combine);
}

template <class S>
void Adjoint(const RowRange<S>& rows, const JacobianArgs<S>& args) {
  using V = xsimd::batch<S>;
  const auto products = [&](Index i, auto access) {
    const V v = access.Load(args.in + i);
    return Fields<3, V>{{access.Load(args.p + i) * v, access.Load(args.q + i) * v, access.Load(args.s + i) * v}};
  };
  const auto combine = [&](Index i, auto access, const Fields<3, V>& blurred) {
    const V x = access.Load(args.rendered + i);
    const V e = x - access.Load(args.truth + i);
    access.Store(args.out + i, SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]));
  };
  BlurRows<3>(rows, products, combine);
}

template <class S>
void WeightedBlur(const RowRange<S>& rows, const WeightedBlurArgs<S>& args) {
  using V = xsimd::batch<S>;
  const auto load = [&](Index i, auto access) { return Fields<1, V>{{access.Load(args.in + i)}}; };
  const auto weigh = [&](Index i, auto access, const Fields<1, V>& blurred) {
    access.Store(args.out + i, access.Load(args.c + i) * blurred.f[0]);
  };
  BlurRows<1>(rows, load, weigh);
}

template <class S>
void BlurAdd(const RowRange<S>& rows, const BlurAddArgs<S>& args) {
  using V = xsimd::batch<S>;
  const V scale(args.scale);
  const auto load = [&](Index i, auto access) { return Fields<1, V>{{access.Load(args.in + i)}}; };
  const auto add = [&](Index i, auto access, const Fields<1, V>& blurred) {
    V addend = access.Load(args.d + i);
    if (args.v != nullptr) addend *= access.Load(args.v + i);
    access.Store(args.out + i, Fma(scale, blurred.f[0], addend));
  };
  BlurRows<1>(rows, load, add);
}

template <class S>
constexpr ImageKernels<S> kKernels{&Windows<S>, &Gradient<S>, &Tangent<S>, &Adjoint<S>, &WeightedBlur<S>, &BlurAdd<S>};

}  // namespace

template <class S>
const ImageKernels<S>& CompiledImageKernels() {
  return kKernels<S>;
}

template const ImageKernels<float>& CompiledImageKernels<float>();
template const ImageKernels<double>& CompiledImageKernels<double>();

}  // namespace VESTA_ISA
}  // namespace vesta
