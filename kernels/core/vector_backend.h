// The vector algebra of the engine, declared once for every memory space. Host bodies are in cpu_backend.cpp; a device
// space defines the same members in its own file, so the engine has one text for both.
#pragma once

#include <concepts>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/pcg_scalars.h"

namespace vesta {

// One double in memory space Space. Reductions write their result there and vector updates read their factor there, so
// that an inner loop need not wait for the host. On the host it points to a plain double.
template <class Space>
struct Slot {
  double* value = nullptr;
};

// Vectors of scalars S in memory space Space. Cheap to construct. All views of one call have the same size; y may be
// the same memory as x unless said otherwise. Reductions are accumulated in double over chunks of fixed size, added in
// a fixed order: results do not depend on the number of threads.
template <class S, class SpaceTag>
class VectorBackend {
 public:
  using Scalar = S;
  using Space = SpaceTag;
  using View = Span<S, Space>;
  using ConstView = Span<const S, Space>;
  using Vector = Buffer<S, Space>;
  using Slot = vesta::Slot<Space>;
  using Slots = Buffer<double, Space>;

  // y = a.
  void Fill(double a, View y);
  // y = x.
  void Copy(ConstView x, View y);
  // y = a x + b y. With b == 0 y is never read (it may hold NaN); with a == 0 x is never read.
  void Axpby(double a, ConstView x, double b, View y);
  // y += a d .* x.
  void AddScaled(double a, ConstView d, ConstView x, View y);
  // y = d .* x.
  void Multiply(ConstView d, ConstView x, View y);
  // y = x ./ d where d != 0, else 0.
  void DivideOrZero(ConstView x, ConstView d, View y);
  // y = min(max(x, lo), hi).
  void Clamp(ConstView x, double lo, double hi, View y);
  // y_k = min(max(x_k, lo d_k), hi d_k), d >= 0.
  void ClampRelative(ConstView x, ConstView d, double lo, double hi, View y);
  // y_k = max(x_k, y_k).
  void Maximum(ConstView x, View y);
  // y = 1 / min(max(d, lo), hi).
  void ClampedInverse(ConstView d, double lo, double hi, View y);
  // y = sqrt(x).
  void Sqrt(ConstView x, View y);
  // y = value_if_positive where x > 0, value_otherwise elsewhere (NaN counts as elsewhere).
  void SelectPositive(ConstView x, double value_if_positive, double value_otherwise, View y);

  // slot = sum_k x_k y_k.
  void Dot(ConstView x, ConstView y, Slot slot);
  // slot = sum_k w_k x_k y_k.
  void WeightedDot(ConstView w, ConstView x, ConstView y, Slot slot);
  // The same, read back at once: for use outside inner loops.
  double Dot(ConstView x, ConstView y);
  double WeightedDot(ConstView w, ConstView x, ConstView y);
  // max_k |x_k|, 0 for an empty vector, NaN when any element is.
  double MaxAbs(ConstView x);
  bool AllFinite(ConstView x);
  // Number of elements that are not > 0.
  Index CountNonPositive(ConstView x);

  // x += alpha p, r -= alpha q, the factor taken from a slot. When it is 0 nothing is read or written. No overlaps.
  void CgStep(Slot alpha, ConstView p, ConstView q, View x, View r);
  // p = z + beta p, the factor taken from a slot; p is not read when it is 0.
  void CgDirection(ConstView z, Slot beta, View p);
  // Runs UpdatePcgScalars where the scalars live.
  void UpdatePcg(PcgPhase phase, Slots& scalars);

  // Sets all scalars; waits, like the reads.
  void Write(HostSpan<const double> values, Slots& slots);
  // Waits, and returns the values.
  double Read(Slot slot);
  std::vector<double> Read(const Slots& slots);
  // The value of the slot, or the value it had at the previous call with this slot, but never an older one; 0 at the
  // first call. Does not wait for work in flight.
  double ReadLagged(Slot slot);
  Slot SlotOf(Slots& slots, int i) { return {slots.data() + i}; }

  // Copies between host memory and this space; wait for the result.
  void FromHost(HostSpan<const S> x, View y);
  void ToHost(ConstView x, HostSpan<S> y);
};

// The requirement of the engine: a VectorBackend of some scalar and memory space.
template <class B>
concept Backend = std::default_initializable<B> &&
    std::same_as<B, VectorBackend<typename B::Scalar, typename B::Space>> && std::floating_point<typename B::Scalar>;

template <class S>
using CpuBackend = VectorBackend<S, Host>;

static_assert(Backend<CpuBackend<float>> && Backend<CpuBackend<double>>);

}  // namespace vesta
