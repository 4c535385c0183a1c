#include "problems/gaussian_splatting/train/adam_kernel.h"

#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

using gs::AdamRange;

// One vector of parameters, or one parameter.
template <class V>
void UpdateAt(const AdamRange& range, Index i) {
  using L = Lanes<V>;
  V first = L::Load(range.first + i), second = L::Load(range.second + i);
  const V rate = range.units ? V(range.rate) * L::Load(range.units + i) : V(range.rate);
  const V step = gs::AdamStep(L::Load(range.gradient + i), rate, V(range.root_correction2), first, second);
  L::Store(range.gradient + i, V(0));
  L::Store(range.first + i, first);
  L::Store(range.second + i, second);
  L::Store(range.parameters + i, L::Load(range.parameters + i) - step);
}

void Update(const AdamRange& range) {
  constexpr Index kWidth = Lanes<FloatLanes>::kWidth;
  const Index whole = range.size / kWidth * kWidth;
  for (Index i = 0; i < whole; i += kWidth) UpdateAt<FloatLanes>(range, i);
  for (Index i = whole; i < range.size; ++i) UpdateAt<float>(range, i);
}

}  // namespace

gs::AdamUpdate CompiledAdamUpdate();
gs::AdamUpdate CompiledAdamUpdate() { return Update; }

}  // namespace VESTA_ISA
}  // namespace vesta
