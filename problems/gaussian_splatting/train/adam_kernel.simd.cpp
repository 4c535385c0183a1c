#include "problems/gaussian_splatting/train/adam_kernel.h"

#include <cmath>

#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

using gs::AdamRange;

// One vector of parameters, or one parameter.
template <class V>
void UpdateAt(const AdamRange& range, Index i) {
  using std::abs, std::sqrt;
  using L = Lanes<V>;
  const V g = L::Load(range.gradient + i);
  const V beta1(gs::kAdamBeta1), beta2(gs::kAdamBeta2), rest1(1 - gs::kAdamBeta1), rest2(1 - gs::kAdamBeta2);
  V m = beta1 * L::Load(range.first + i) + rest1 * g;
  m = Select(abs(m) < V(gs::kAdamFirstFloor), V(0), m);
  const V v = beta2 * L::Load(range.second + i) + (rest2 * g * g + V(gs::kAdamSecondFloor));
  L::Store(range.gradient + i, V(0));
  L::Store(range.first + i, m);
  L::Store(range.second + i, v);
  const V step = V(range.rate) * m / (sqrt(v) * V(range.root_correction2));
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
