// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/rounding_columns.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "kernels/core/random.h"
#include "solver/internal/normal_equations/rounding_columns.h"

namespace vesta {

namespace rounding_internal {

// Returns J^T w with w_i = 1 / (J v)_i for a random v. Because (J v)_i is about the largest entry of row i, entry k is
// about the sum over the rows of J_ik / (largest entry of row i).
template <Backend B>
std::vector<typename B::Scalar> SharesOfRows(B& backend, std::span<LinearizationAdaptor<B>* const> batches) {
  const Index n = batches.front()->num_parameters();
  std::vector<typename B::Scalar> host(static_cast<std::size_t>(n));
  CounterRandom random(1, 0);
  for (auto& value : host) value = static_cast<typename B::Scalar>(0.5 + random.Uniform());
  typename B::Vector v(n), part(n), sum(n), row, one;
  backend.FromHost({host.data(), n}, v);
  for (LinearizationAdaptor<B>* batch : batches) {
    row.Resize(batch->num_residuals());
    one.Resize(batch->num_residuals());
    backend.Fill(1, one);
    batch->ApplyJ(v, row);
    backend.DivideOrZero(one, row, row);
    batch->ApplyJT(row, part);
    backend.Axpby(1.0, part, 1.0, sum);
  }
  backend.ToHost(sum, {host.data(), n});
  return host;
}

// Needs a positive value.
template <class S>
S MedianOfPositive(std::vector<S> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](S value) { return !(value > S(0)); }), values.end());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace rounding_internal

template <Backend B>
typename B::Vector RaiseRoundingColumns(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                        typename B::ConstVectorView diag_h) {
  using S = typename B::Scalar;
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const double largest = backend.MaxAbs(diag_h), tiny = 256 * kEpsilon * kEpsilon * largest;
  typename B::Vector raised(diag_h.size());
  backend.Fill(-tiny, raised);
  backend.Axpby(1.0, diag_h, 1.0, raised);
  const Index small = backend.CountNonPositive(raised);
  if (small == 0 || !(largest > 0)) return {};
  const Index zeros = backend.CountNonPositive(diag_h);
  std::vector<S> host(static_cast<std::size_t>(diag_h.size()));
  backend.ToHost(diag_h, {host.data(), diag_h.size()});
  if (small > zeros) {
    const std::vector<S> shares = rounding_internal::SharesOfRows<B>(backend, batches);
    for (std::size_t k = 0; k < host.size(); ++k) {
      const auto squared = static_cast<double>(host[k]), share = std::abs(static_cast<double>(shares[k]));
      if (!(squared > 0 && squared <= tiny && share * share <= kEpsilon)) continue;
      host[k] = static_cast<S>(std::min(squared / (share * share), largest));
    }
  }
  if (zeros > 0) {
    const S median = rounding_internal::MedianOfPositive(host);
    for (S& value : host) value = value > S(0) ? value : median;
  }
  backend.FromHost({host.data(), diag_h.size()}, raised);
  return raised;
}

}  // namespace vesta
