// SPDX-License-Identifier: Apache-2.0
// Host vectors for problems, and models with given means.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "solver/internal/derivative_check.inl"

namespace vesta::gs::test {

template <class S>
HostBuffer<S> RandomVector(Index size, std::uint64_t seed) {
  CpuBackend<S> backend;
  HostBuffer<S> v(size);
  FillRandom(backend, seed, v.view());
  return v;
}

template <class S>
std::vector<S> ToVector(const HostBuffer<S>& v) {
  return {v.begin(), v.end()};
}

template <class S>
HostBuffer<S> ApplyH(LinearizationAdaptor<CpuBackend<S>>& linearization, const HostBuffer<S>& v) {
  HostBuffer<S> Hv(v.size());
  linearization.ApplyH(v, Hv);
  return Hv;
}
// The same by ApplyJ, ApplyW and ApplyJT.
template <class S>
HostBuffer<S> ApplyParts(LinearizationAdaptor<CpuBackend<S>>& linearization, const HostBuffer<S>& v) {
  HostBuffer<S> Jv(linearization.num_residuals()), WJv(Jv.size()), product(v.size());
  linearization.ApplyJ(v, Jv);
  linearization.ApplyW(Jv, WJv);
  linearization.ApplyJT(WJv, product);
  return product;
}

template <class S>
double Norm(const HostBuffer<S>& v) {
  CpuBackend<S> backend;
  return std::sqrt(backend.Dot(v, v));
}
template <class S>
double Distance(const HostBuffer<S>& a, const HostBuffer<S>& b) {
  CpuBackend<S> backend;
  HostBuffer<S> difference;
  difference.CopyFrom(a);
  backend.Axpby(-1, b, 1, difference);
  return Norm(difference);
}

inline SplatModel ModelAt(const std::vector<std::array<float, 3>>& means) {
  SplatModel model;
  model.Resize(0, static_cast<Index>(means.size()));
  for (std::size_t i = 0; i < means.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) model.attribute(splat::kMean + static_cast<int>(k))[i] = means[i][k];
  }
  return model;
}

}  // namespace vesta::gs::test
