// SPDX-License-Identifier: Apache-2.0
// Vector algebra on the GPU. All operations are memory-bound. Neighbouring threads process neighbouring elements.
#include <limits>

#include "kernels/core/cuda_backend.h"
#include "kernels/core/launch.cuh"

namespace vesta {
namespace {

template <class X, class Y>
void CheckSizes(const X& x, const Y& y) {
  if (x.size() != y.size()) {
    throw Error(kBadArgument,
                "vectors of different sizes, " + std::to_string(x.size()) + " and " + std::to_string(y.size()));
  }
}

// Partial results of reductions, and one final result for the host. The reductions of a host thread run in stream
// order, so they share this memory.
double* Partials() {
  thread_local DeviceBuffer<double> buffer(kMaxChunks + 1);
  return buffer.data();
}

struct PartialTerm {
  const double* partials;
  VESTA_HD double operator()(Index i) const { return partials[i]; }
};

// *result = the reduction of term(i) over [0, size) by `add`, or 0 if size is 0.
template <class Term, class Add>
void Reduce(Index size, const Term& term, const Add& add, double* result) {
  const Index chunk = ChunkSize(size), chunks = (size + chunk - 1) / chunk;
  if (chunks <= 1) {
    device::Launch(ReduceChunks<Term, Add>{term, add, size, chunk, result}, 1, "reduction");
    return;
  }
  double* partials = Partials();
  device::Launch(ReduceChunks<Term, Add>{term, add, size, chunk, partials}, chunks, "reduction");
  device::Launch(ReduceChunks<PartialTerm, Add>{{partials}, add, chunks, chunks, result}, 1, "reduction");
}

template <class Term, class Add>
double ReduceAndRead(Index size, const Term& term, const Add& add) {
  double* on_device = Partials() + kMaxChunks;
  Reduce(size, term, add, on_device);
  double result = 0;
  device::CopyToHost(&result, on_device, sizeof(double));
  return result;
}

template <class S>
struct DotTerm {
  const S *x, *y;
  VESTA_HD double operator()(Index i) const { return static_cast<double>(x[i]) * static_cast<double>(y[i]); }
};
template <class S>
struct WeightedDotTerm {
  const S *w, *x, *y;
  VESTA_HD double operator()(Index i) const {
    return static_cast<double>(w[i]) * static_cast<double>(x[i]) * static_cast<double>(y[i]);
  }
};
template <class S>
struct MagnitudeTerm {
  const S* x;
  VESTA_HD double operator()(Index i) const { return static_cast<double>(x[i] < S(0) ? -x[i] : x[i]); }
};
template <class S>
struct NotFiniteTerm {
  const S* x;
  VESTA_HD double operator()(Index i) const { return x[i] - x[i] == S(0) ? 0.0 : 1.0; }
};
template <class S>
struct NotPositiveTerm {
  const S* x;
  VESTA_HD double operator()(Index i) const { return x[i] > S(0) ? 0.0 : 1.0; }
};

// Handles NaN as std::min and std::max do on the host.
template <class S>
VESTA_HD S Clamped(S x, S lo, S hi) {
  const S raised = x < lo ? lo : x;
  return hi < raised ? hi : raised;
}

}  // namespace

template <class S, class Space>
void VectorBackend<S, Space>::Fill(double a, VectorView y) {
  const S value = static_cast<S>(a);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = value; }, "Fill");
}

template <class S, class Space>
void VectorBackend<S, Space>::Copy(ConstVectorView x, VectorView y) {
  CheckSizes(x, y);
  device::Copy(y.data(), x.data(), static_cast<std::size_t>(y.size()) * sizeof(S));
}

template <class S, class Space>
void VectorBackend<S, Space>::Axpby(double a, ConstVectorView x, double b, VectorView y) {
  CheckSizes(x, y);
  const S sa = static_cast<S>(a), sb = static_cast<S>(b);
  if (b == 0) {
    if (a == 0) return Fill(0, y);
    device::ForEach(
        y.size(), [=] __device__(Index i) { y[i] = sa * x[i]; }, "Axpby");
  } else if (a == 0) {
    device::ForEach(
        y.size(), [=] __device__(Index i) { y[i] = sb * y[i]; }, "Axpby");
  } else {
    device::ForEach(
        y.size(), [=] __device__(Index i) { y[i] = sa * x[i] + sb * y[i]; }, "Axpby");
  }
}

template <class S, class Space>
void VectorBackend<S, Space>::AddScaled(double a, ConstVectorView d, ConstVectorView x, VectorView y) {
  CheckSizes(d, y);
  CheckSizes(x, y);
  const S sa = static_cast<S>(a);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] += sa * d[i] * x[i]; }, "AddScaled");
}

template <class S, class Space>
void VectorBackend<S, Space>::Multiply(ConstVectorView d, ConstVectorView x, VectorView y) {
  CheckSizes(d, y);
  CheckSizes(x, y);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = d[i] * x[i]; }, "Multiply");
}

template <class S, class Space>
void VectorBackend<S, Space>::DivideOrZero(ConstVectorView x, ConstVectorView d, VectorView y) {
  CheckSizes(x, y);
  CheckSizes(d, y);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = d[i] != S(0) ? x[i] / d[i] : S(0); }, "DivideOrZero");
}

template <class S, class Space>
void VectorBackend<S, Space>::Clamp(ConstVectorView x, double lo, double hi, VectorView y) {
  CheckSizes(x, y);
  const S slo = static_cast<S>(lo), shi = static_cast<S>(hi);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = Clamped(x[i], slo, shi); }, "Clamp");
}

template <class S, class Space>
void VectorBackend<S, Space>::ClampRelative(ConstVectorView x, ConstVectorView d, double lo, double hi, VectorView y) {
  CheckSizes(x, y);
  CheckSizes(d, y);
  const S slo = static_cast<S>(lo), shi = static_cast<S>(hi);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = Clamped(x[i], slo * d[i], shi * d[i]); }, "ClampRelative");
}

template <class S, class Space>
void VectorBackend<S, Space>::Maximum(ConstVectorView x, VectorView y) {
  CheckSizes(x, y);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = x[i] < y[i] ? y[i] : x[i]; }, "Maximum");
}

template <class S, class Space>
void VectorBackend<S, Space>::ClampedInverse(ConstVectorView d, double lo, double hi, VectorView y) {
  CheckSizes(d, y);
  const S slo = static_cast<S>(lo), shi = static_cast<S>(hi);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = S(1) / Clamped(d[i], slo, shi); }, "ClampedInverse");
}

template <class S, class Space>
void VectorBackend<S, Space>::Sqrt(ConstVectorView x, VectorView y) {
  CheckSizes(x, y);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = sqrt(x[i]); }, "Sqrt");
}

template <class S, class Space>
void VectorBackend<S, Space>::SelectPositive(ConstVectorView x, double value_if_positive, double value_otherwise,
                                             VectorView y) {
  CheckSizes(x, y);
  const S yes = static_cast<S>(value_if_positive), no = static_cast<S>(value_otherwise);
  device::ForEach(
      y.size(), [=] __device__(Index i) { y[i] = x[i] > S(0) ? yes : no; }, "SelectPositive");
}

template <class S, class Space>
void VectorBackend<S, Space>::Dot(ConstVectorView x, ConstVectorView y, Slot slot) {
  CheckSizes(x, y);
  Reduce(x.size(), DotTerm<S>{x.data(), y.data()}, AddUp{}, slot.value);
}

template <class S, class Space>
void VectorBackend<S, Space>::WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y, Slot slot) {
  CheckSizes(w, y);
  CheckSizes(x, y);
  Reduce(x.size(), WeightedDotTerm<S>{w.data(), x.data(), y.data()}, AddUp{}, slot.value);
}

template <class S, class Space>
double VectorBackend<S, Space>::Dot(ConstVectorView x, ConstVectorView y) {
  CheckSizes(x, y);
  return ReduceAndRead(x.size(), DotTerm<S>{x.data(), y.data()}, AddUp{});
}

template <class S, class Space>
double VectorBackend<S, Space>::WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y) {
  CheckSizes(w, y);
  CheckSizes(x, y);
  return ReduceAndRead(x.size(), WeightedDotTerm<S>{w.data(), x.data(), y.data()}, AddUp{});
}

template <class S, class Space>
double VectorBackend<S, Space>::MaxAbs(ConstVectorView x) {
  return ReduceAndRead(x.size(), MagnitudeTerm<S>{x.data()}, LargestOrNaN{});
}

template <class S, class Space>
bool VectorBackend<S, Space>::AllFinite(ConstVectorView x) {
  return ReduceAndRead(x.size(), NotFiniteTerm<S>{x.data()}, AddUp{}) == 0;
}

template <class S, class Space>
Index VectorBackend<S, Space>::CountNonPositive(ConstVectorView x) {
  return static_cast<Index>(ReduceAndRead(x.size(), NotPositiveTerm<S>{x.data()}, AddUp{}));
}

template <class S, class Space>
void VectorBackend<S, Space>::CgStep(Slot alpha, ConstVectorView p, ConstVectorView q, VectorView x, VectorView r) {
  const double* factor = alpha.value;
  device::ForEach(
      x.size(),
      [=] __device__(Index i) {
        if (*factor == 0) return;
        const S a = static_cast<S>(*factor);
        x[i] += a * p[i];
        r[i] -= a * q[i];
      },
      "CgStep");
}

template <class S, class Space>
void VectorBackend<S, Space>::CgDirection(ConstVectorView z, Slot beta, VectorView p) {
  CheckSizes(z, p);
  const double* factor = beta.value;
  device::ForEach(
      p.size(),
      [=] __device__(Index i) {
        const double b = *factor;
        p[i] = b == 0 ? z[i] : z[i] + static_cast<S>(b) * p[i];
      },
      "CgDirection");
}

template <class S, class Space>
void VectorBackend<S, Space>::UpdatePcg(PcgPhase phase, Slots& scalars) {
  double* values = scalars.data();
  device::ForEach(
      1, [=] __device__(Index) { UpdatePcgScalars(phase, values); }, "UpdatePcg");
}

template <class S, class Space>
void VectorBackend<S, Space>::Write(HostSpan<const double> values, Slots& slots) {
  if (slots.size() != values.size()) slots.ResizeForOverwrite(values.size());
  device::DiscardLagged(slots.data(), static_cast<std::size_t>(slots.size()));
  slots.CopyFrom(values);
}

template <class S, class Space>
double VectorBackend<S, Space>::Read(Slot slot) {
  double value = 0;
  device::CopyToHost(&value, slot.value, sizeof(double));
  return value;
}

template <class S, class Space>
std::vector<double> VectorBackend<S, Space>::Read(const Slots& slots) {
  std::vector<double> values(static_cast<std::size_t>(slots.size()));
  slots.CopyTo({values.data(), slots.size()});
  return values;
}

template <class S, class Space>
double VectorBackend<S, Space>::ReadLagged(Slot slot) {
  return device::ReadLagged(slot.value);
}

template <class S, class Space>
void VectorBackend<S, Space>::FromHost(HostSpan<const S> x, VectorView y) {
  CheckSizes(x, y);
  device::CopyFromHost(y.data(), x.data(), static_cast<std::size_t>(y.size()) * sizeof(S));
}

template <class S, class Space>
void VectorBackend<S, Space>::ToHost(ConstVectorView x, HostSpan<S> y) {
  CheckSizes(x, y);
  device::CopyToHost(y.data(), x.data(), static_cast<std::size_t>(y.size()) * sizeof(S));
}

template class VectorBackend<float, Device>;
template class VectorBackend<double, Device>;

}  // namespace vesta
