#include "kernels/image/image_kernels.h"

#include "kernels/image/lane_access.h"  // before the formulas: they call what it declares
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

  template <int kCount>
  void Add(const Several<V, kCount>& values) {
    Unrolled<kCount>([&](auto i) { lanes += values.v[i]; });
  }
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

constexpr auto kAsTheyAre = [](const auto& fields) { return fields; };
constexpr auto kNothing = [](int) {};

// u = x + y and e = x - y of two images, of which the four fields of a window are made.
template <class S>
auto SumAndDifference(const S* rendered, const S* truth) {
  return [=](Index i, auto access) {
    const auto x = access.Load(rendered + i), y = access.Load(truth + i);
    return Fields<2, std::remove_const_t<decltype(x)>>{{x + y, x - y}};
  };
}
constexpr auto kWithSquares = []<class T>(const Fields<2, T>& stored) {
  const T &u = stored.f[0], &e = stored.f[1];
  return Fields<4, T>{{u, e, u * u, e * e}};
};
template <class T>
SsimWindow<T> WindowOf(const Fields<4, T>& blurred) {
  return SsimWindow<T>(blurred.f[0], blurred.f[1], blurred.f[2], blurred.f[3]);
}

// The blurred rows of the range, from fields that `load` reads from images.
template <int kStored, int N, class S, class Load, class Derive, class Out, class EndRow>
void BlurRows(const RowRange<S>& rows, const Load& load, const Derive& derive, const Out& out, const EndRow& end_row) {
  ScratchRows<S> scratch(rows);
  WindowBlur<kStored, N, S> blur(rows, scratch);
  ImageRows images(rows, blur, blur.InputBegin(rows.begin), load);
  BlurredRows blurred(images, blur, rows.begin, rows.end, derive, out, end_row);
  blurred.MakeUpTo(rows.end);
}

// Sums of the absolute value.
template <class S>
struct AbsoluteSums {
  RowSum<S> absolute, floored;

  template <class Access, class T>
  void Add(const Access& access, const FlooredAbsolute<T>& l1) {
    absolute.Add(access.Used(l1.absolute));
    floored.Add(access.Used(l1.value));
  }
  void Write(double* sums) {
    sums[0] = absolute.Take();
    sums[1] = floored.Take();
  }
};

template <class S>
void Windows(const RowRange<S>& rows, const WindowArgs<S>& args) {
  const S l1_floor = args.floor, inverse_floor = S(1) / args.floor;
  AbsoluteSums<S> absolute;
  RowSum<S> dissimilarity;
  const auto measure = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    const SsimWindow<T> window = WindowOf(blurred);
    const T value = window.Dissimilarity();
    dissimilarity.Add(access.Used(value));
    absolute.Add(access, FlooredAbsolute<T>(access.Load(args.rendered + i) - access.Load(args.truth + i), T(l1_floor),
                                            T(inverse_floor)));
    if (args.dissimilarity != nullptr) access.Store(args.dissimilarity + i, value);
    if (args.p == nullptr) return;
    const SsimSlopes<T> slopes(window);
    access.Store(args.p + i, slopes.p);
    access.Store(args.q + i, slopes.q);
    access.Store(args.s + i, slopes.s);
  };
  const auto end_row = [&](int row) {
    double* const sums = args.row_sums + 3 * (Index{rows.plane} * rows.height + row);
    absolute.Write(sums);
    sums[2] = dissimilarity.Take();
  };
  BlurRows<2, 4>(rows, SumAndDifference(args.rendered, args.truth), kWithSquares, measure, end_row);
}

template <class S>
void Gradient(const RowRange<S>& rows, const GradientArgs<S>& args) {
  const S l1 = args.l1, ssim = args.ssim;
  const S l1_floor = args.floor, inverse_floor = S(1) / args.floor;
  ScratchRows<S> scratch(rows);
  WindowBlur<2, 4, S> windows(rows, scratch);
  WindowBlur<3, 3, S> slopes(rows, scratch);
  const int begin = slopes.InputBegin(rows.begin), end = slopes.InputEnd(rows.end);

  // Slopes of all windows that the range's pixels are in; what is summed or kept, of the range's own windows.
  RowSum<S> dissimilarity;
  const auto measure = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const SsimWindow<T> window = WindowOf(blurred);
    const SsimSlopes<T> slope(window);
    dissimilarity.Add(access.Used(window.Dissimilarity()));
    access.StoreAligned(slopes.Row(row, 0) + column, slope.p);
    access.StoreAligned(slopes.Row(row, 1) + column, slope.q);
    access.StoreAligned(slopes.Row(row, 2) + column, slope.s);
    if (args.curvature == nullptr || row < rows.begin || row >= rows.end) return;
    access.Store(args.curvature + PositionOf(rows, row, column), SsimWindowCurvature(window, slope));
  };
  double* const plane_sums = args.row_sums + 3 * Index{rows.plane} * rows.height;
  const auto end_windows = [&](int row) {
    const double sum = dissimilarity.Take();
    if (row >= rows.begin && row < rows.end) plane_sums[3 * row + 2] = sum;
  };

  AbsoluteSums<S> absolute;
  const auto combine = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(args.rendered + i);
    const T e = x - access.Load(args.truth + i);
    const FlooredAbsolute<T> l1_at(e, T(l1_floor), T(inverse_floor));
    absolute.Add(access, l1_at);
    const T by_ssim = SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]);
    access.Store(args.gradient + i, Fma(T(ssim), by_ssim, T(l1) * l1_at.slope));
    if (args.diagonal != nullptr) {
      access.Store(args.diagonal + i, Fma(T(ssim), blurred.f[2], T(l1) * l1_at.Curvature()));
    }
  };
  const auto end_row = [&](int row) { absolute.Write(plane_sums + 3 * row); };

  const auto load = SumAndDifference(args.rendered, args.truth);
  ImageRows images(rows, windows, windows.InputBegin(begin), load);
  BlurredRows first(images, windows, begin, end, kWithSquares, measure, end_windows);
  BlurredRows second(first, slopes, rows.begin, rows.end, kAsTheyAre, combine, end_row);
  second.MakeUpTo(rows.end);
}

template <class S>
void Tangent(const RowRange<S>& rows, const JacobianArgs<S>& args) {
  const auto products = [&](Index i, auto access) {
    using T = typename decltype(access)::T;
    const T v = access.Load(args.in + i), x = access.Load(args.rendered + i);
    return Fields<3, T>{{v, x * v, (x - access.Load(args.truth + i)) * v}};
  };
  const auto combine = [&](int row, int column, auto access, const auto& blurred) {
    const Index i = PositionOf(rows, row, column);
    access.Store(args.out + i, SsimTangent(access.Load(args.p + i), access.Load(args.q + i), access.Load(args.s + i),
                                           blurred.f[0], blurred.f[1], blurred.f[2]));
  };
  BlurRows<3, 3>(rows, products, kAsTheyAre, combine, kNothing);
}

template <class S>
void Adjoint(const RowRange<S>& rows, const JacobianArgs<S>& args) {
  const auto products = [&](Index i, auto access) {
    using T = typename decltype(access)::T;
    const T v = access.Load(args.in + i);
    return Fields<3, T>{{access.Load(args.p + i) * v, access.Load(args.q + i) * v, access.Load(args.s + i) * v}};
  };
  const auto combine = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(args.rendered + i);
    const T e = x - access.Load(args.truth + i);
    access.Store(args.out + i, SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]));
  };
  BlurRows<3, 3>(rows, products, kAsTheyAre, combine, kNothing);
}

template <class S>
void Curvature(const RowRange<S>& rows, const CurvatureArgs<S>& args) {
  const S scale = args.scale;
  ScratchRows<S> scratch(rows);
  WindowBlur<1, 1, S> inner(rows, scratch), outer(rows, scratch);
  const int begin = outer.InputBegin(rows.begin), end = outer.InputEnd(rows.end);
  const auto load = [&](Index i, auto access) {
    using T = typename decltype(access)::T;
    return Fields<1, T>{{access.Load(args.v + i)}};
  };
  const auto weigh = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const T c = access.Load(args.c + PositionOf(rows, row, column));
    access.StoreAligned(outer.Row(row, 0) + column, c * blurred.f[0]);
  };
  const auto add = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    access.Store(args.out + i, Fma(T(scale), blurred.f[0], access.Load(args.d + i) * access.Load(args.v + i)));
  };
  ImageRows images(rows, inner, inner.InputBegin(begin), load);
  BlurredRows first(images, inner, begin, end, kAsTheyAre, weigh, kNothing);
  BlurredRows second(first, outer, rows.begin, rows.end, kAsTheyAre, add, kNothing);
  second.MakeUpTo(rows.end);
}

template <class S>
void BlurAdd(const RowRange<S>& rows, const BlurAddArgs<S>& args) {
  const S scale = args.scale;
  const auto load = [&](Index i, auto access) {
    using T = typename decltype(access)::T;
    return Fields<1, T>{{access.Load(args.in + i)}};
  };
  const auto add = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    access.Store(args.out + i, Fma(T(scale), blurred.f[0], access.Load(args.d + i)));
  };
  BlurRows<1, 1>(rows, load, kAsTheyAre, add, kNothing);
}

template <class S>
constexpr ImageKernels<S> kKernels{&Windows<S>, &Gradient<S>, &Tangent<S>, &Adjoint<S>, &Curvature<S>, &BlurAdd<S>};

}  // namespace

template <class S>
const ImageKernels<S>& CompiledImageKernels() {
  return kKernels<S>;
}

template const ImageKernels<float>& CompiledImageKernels<float>();
template const ImageKernels<double>& CompiledImageKernels<double>();

}  // namespace VESTA_ISA
}  // namespace vesta
