// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam_kernel.h"

#include "kernels/math/lanes.h"

namespace vesta::gs {
inline namespace VESTA_ISA {
namespace {

// Updates one vector of parameters, or one parameter.
template <class V>
void UpdateAt(const AdamRange& range, Index i) {
  using L = Lanes<V>;
  const V gradient = L::Load(range.gradient + i);
  if (!L::Any(gradient != V(0))) return;
  V first = L::Load(range.first + i), second = L::Load(range.second + i);
  const V rate = range.units ? V(range.rate) * L::Load(range.units + i) : V(range.rate);
  const V step = AdamStep(gradient, rate, range.beta2, V(range.root_correction2), first, second);
  L::Store(range.gradient + i, V(0));
  L::Store(range.first + i, first);
  L::Store(range.second + i, second);
  L::Store(range.parameters + i, L::Load(range.parameters + i) - step);
}

// Calls body(V(), i) for the whole vectors in [begin, end), then for the remaining elements.
template <class Body>
void ForVectors(Index begin, Index end, const Body& body) {
  constexpr Index kWidth = Lanes<FloatLanes>::kWidth;
  Index i = begin;
  for (; i + kWidth <= end; i += kWidth) body(FloatLanes(0), i);
  for (; i < end; ++i) body(0.0f, i);
}

void Step(const AdamRange& range) {
  ForVectors(0, range.size, [&](auto v, Index i) { UpdateAt<decltype(v)>(range, i); });
}

void StepBlocks(const BlockAdamArrays& arrays, Index begin, Index end) {
  ForVectors(begin, end, [&](auto v, Index i) { BlockAdamStep<decltype(v)>(arrays, i); });
}

void TurnBases(const BlockAdamArrays& arrays, Index begin, Index end) {
  ForVectors(begin, end, [&](auto v, Index i) { RotateBasis<decltype(v)>(arrays, i); });
}

}  // namespace

const AdamKernels& CompiledAdamKernels() {
  static constexpr AdamKernels kKernels = {Step, StepBlocks, TurnBases};
  return kKernels;
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
