// SPDX-License-Identifier: Apache-2.0
// Vector algebra on the host. All operations are memory-bound and split long vectors among all threads.
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/vector_backend.h"

namespace vesta {
namespace {

// Elements per task, and per partial sum of a reduction. Constant, so sums do not depend on the thread count.
constexpr Index kGrain = 8192;
// Partial sums kept side by side within a chunk, one SIMD lane each.
constexpr int kLanes = 8;

template <class X, class Y>
void CheckSizes(const X& x, const Y& y) {
  VESTA_CHECK(x.size() == y.size(), "vectors of different sizes, {} and {}", x.size(), y.size());
}

template <class Body>
void ForEach(Index n, const Body& body) {
  if (n <= kGrain) {
    for (Index i = 0; i < n; ++i) body(i);
    return;
  }
  ParallelFor(n, kGrain, body);
}

template <class T, class Body>
T Sum(Index n, const Body& body) {
  return n <= kGrain ? body(Index{0}, n) : ParallelSum<T>(n, kGrain, body);
}

// Sum of term(i) over [0, n) in double.
template <class Term>
double SumTerms(Index n, const Term& term) {
  return Sum<double>(n, [&term](Index begin, Index end) {
    double lanes[kLanes] = {};
    Index i = begin;
    for (; i + kLanes <= end; i += kLanes) {
      for (int lane = 0; lane < kLanes; ++lane) lanes[lane] += term(i + lane);
    }
    for (int lane = 0; i < end; ++i, ++lane) lanes[lane] += term(i);
    double sum = 0;
    for (const double value : lanes) sum += value;
    return sum;
  });
}

}  // namespace

template <class S, class Space>
void VectorBackend<S, Space>::Fill(double a, VectorView y) {
  const S value = static_cast<S>(a);
  ForEach(y.size(), [=](Index i) { y[i] = value; });
}

template <class S, class Space>
void VectorBackend<S, Space>::Copy(ConstVectorView x, VectorView y) {
  CheckSizes(x, y);
  ForEach(y.size(), [=](Index i) { y[i] = x[i]; });
}

template <class S, class Space>
void VectorBackend<S, Space>::Axpby(double a, ConstVectorView x, double b, VectorView y) {
  CheckSizes(x, y);
  const S sa = static_cast<S>(a), sb = static_cast<S>(b);
  if (b == 0) {
    if (a == 0) return Fill(0, y);
    ForEach(y.size(), [=](Index i) { y[i] = sa * x[i]; });
  } else if (a == 0) {
    ForEach(y.size(), [=](Index i) { y[i] = sb * y[i]; });
  } else {
    ForEach(y.size(), [=](Index i) { y[i] = sa * x[i] + sb * y[i]; });
  }
}

template <class S, class Space>
void VectorBackend<S, Space>::AddScaled(double a, ConstVectorView d, ConstVectorView x, VectorView y) {
  CheckSizes(d, y);
  CheckSizes(x, y);
  const S sa = static_cast<S>(a);
  ForEach(y.size(), [=](Index i) { y[i] += sa * d[i] * x[i]; });
}

template <class S, class Space>
void VectorBackend<S, Space>::Multiply(ConstVectorView d, ConstVectorView x, VectorView y) {
  CheckSizes(d, y);
  CheckSizes(x, y);
  ForEach(y.size(), [=](Index i) { y[i] = d[i] * x[i]; });
}

template <class S, class Space>
void VectorBackend<S, Space>::DivideOrZero(ConstVectorView x, ConstVectorView d, VectorView y) {
  CheckSizes(x, y);
  CheckSizes(d, y);
  ForEach(y.size(), [=](Index i) { y[i] = d[i] != S(0) ? x[i] / d[i] : S(0); });
}

template <class S, class Space>
void VectorBackend<S, Space>::Clamp(ConstVectorView x, double lo, double hi, VectorView y) {
  CheckSizes(x, y);
  const S slo = static_cast<S>(lo), shi = static_cast<S>(hi);
  ForEach(y.size(), [=](Index i) { y[i] = std::min(std::max(x[i], slo), shi); });
}

template <class S, class Space>
void VectorBackend<S, Space>::ClampRelative(ConstVectorView x, ConstVectorView d, double lo, double hi, VectorView y) {
  CheckSizes(x, y);
  CheckSizes(d, y);
  const S slo = static_cast<S>(lo), shi = static_cast<S>(hi);
  ForEach(y.size(), [=](Index i) { y[i] = std::min(std::max(x[i], slo * d[i]), shi * d[i]); });
}

template <class S, class Space>
void VectorBackend<S, Space>::Maximum(ConstVectorView x, VectorView y) {
  CheckSizes(x, y);
  ForEach(y.size(), [=](Index i) { y[i] = std::max(x[i], y[i]); });
}

template <class S, class Space>
void VectorBackend<S, Space>::ClampedInverse(ConstVectorView d, double lo, double hi, VectorView y) {
  CheckSizes(d, y);
  const S slo = static_cast<S>(lo), shi = static_cast<S>(hi);
  ForEach(y.size(), [=](Index i) { y[i] = S(1) / std::min(std::max(d[i], slo), shi); });
}

template <class S, class Space>
void VectorBackend<S, Space>::Sqrt(ConstVectorView x, VectorView y) {
  CheckSizes(x, y);
  ForEach(y.size(), [=](Index i) { y[i] = std::sqrt(x[i]); });
}

template <class S, class Space>
void VectorBackend<S, Space>::SelectPositive(ConstVectorView x, double value_if_positive, double value_otherwise,
                                             VectorView y) {
  CheckSizes(x, y);
  const S yes = static_cast<S>(value_if_positive), no = static_cast<S>(value_otherwise);
  ForEach(y.size(), [=](Index i) { y[i] = x[i] > S(0) ? yes : no; });
}

template <class S, class Space>
void VectorBackend<S, Space>::Dot(ConstVectorView x, ConstVectorView y, Slot slot) {
  CheckSizes(x, y);
  *slot.value = SumTerms(x.size(), [=](Index i) { return static_cast<double>(x[i]) * static_cast<double>(y[i]); });
}

template <class S, class Space>
void VectorBackend<S, Space>::WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y, Slot slot) {
  CheckSizes(w, y);
  CheckSizes(x, y);
  *slot.value = SumTerms(x.size(), [=](Index i) {
    return static_cast<double>(w[i]) * static_cast<double>(x[i]) * static_cast<double>(y[i]);
  });
}

template <class S, class Space>
double VectorBackend<S, Space>::Dot(ConstVectorView x, ConstVectorView y) {
  double result = 0;
  Dot(x, y, Slot{&result});
  return result;
}

template <class S, class Space>
double VectorBackend<S, Space>::WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y) {
  double result = 0;
  WeightedDot(w, x, y, Slot{&result});
  return result;
}

template <class S, class Space>
double VectorBackend<S, Space>::MaxAbs(ConstVectorView x) {
  return Sum<Largest>(x.size(),
                      [=](Index begin, Index end) {
                        S largest = 0;
                        bool nan = false;
                        for (Index i = begin; i < end; ++i) {
                          const S magnitude = std::abs(x[i]);
                          largest = magnitude > largest ? magnitude : largest;
                          nan |= magnitude != magnitude;
                        }
                        return Largest{nan ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(largest)};
                      })
      .value;
}

template <class S, class Space>
bool VectorBackend<S, Space>::AllFinite(ConstVectorView x) {
  return Sum<Index>(x.size(), [=](Index begin, Index end) {
           Index bad = 0;
           for (Index i = begin; i < end; ++i) bad += std::isfinite(x[i]) ? 0 : 1;
           return bad;
         }) == 0;
}

template <class S, class Space>
Index VectorBackend<S, Space>::CountNonPositive(ConstVectorView x) {
  return Sum<Index>(x.size(), [=](Index begin, Index end) {
    Index count = 0;
    for (Index i = begin; i < end; ++i) count += x[i] > S(0) ? 0 : 1;
    return count;
  });
}

template <class S, class Space>
void VectorBackend<S, Space>::CgStep(Slot alpha, ConstVectorView p, ConstVectorView q, VectorView x, VectorView r) {
  const S a = static_cast<S>(*alpha.value);
  if (*alpha.value == 0) return;
  ForEach(x.size(), [=](Index i) {
    x[i] += a * p[i];
    r[i] -= a * q[i];
  });
}

template <class S, class Space>
void VectorBackend<S, Space>::CgDirection(ConstVectorView z, Slot beta, VectorView p) {
  Axpby(1.0, z, *beta.value, p);
}

template <class S, class Space>
void VectorBackend<S, Space>::UpdatePcg(PcgPhase phase, Slots& scalars) {
  UpdatePcgScalars(phase, scalars.data());
}

template <class S, class Space>
void VectorBackend<S, Space>::Write(HostSpan<const double> values, Slots& slots) {
  slots.CopyFrom(values);
}

template <class S, class Space>
double VectorBackend<S, Space>::Read(Slot slot) {
  return *slot.value;
}

template <class S, class Space>
std::vector<double> VectorBackend<S, Space>::Read(const Slots& slots) {
  return {slots.begin(), slots.end()};
}

template <class S, class Space>
double VectorBackend<S, Space>::ReadLagged(Slot slot) {
  return *slot.value;
}

template <class S, class Space>
void VectorBackend<S, Space>::FromHost(HostSpan<const S> x, VectorView y) {
  Copy(x, y);
}

template <class S, class Space>
void VectorBackend<S, Space>::ToHost(ConstVectorView x, HostSpan<S> y) {
  Copy(x, y);
}

template class VectorBackend<float, Host>;
template class VectorBackend<double, Host>;

}  // namespace vesta
