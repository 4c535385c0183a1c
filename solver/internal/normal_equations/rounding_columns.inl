// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/rounding_columns.h.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "kernels/core/random.h"
#include "solver/internal/normal_equations/raised_diagonal.h"
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

}  // namespace rounding_internal

template <Backend B>
typename B::Vector RaiseRoundingColumns(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                        typename B::ConstVectorView diag_h) {
  using S = typename B::Scalar;
  const double largest = backend.MaxAbs(diag_h);
  typename B::Vector raised(diag_h.size());
  backend.Fill(-TinyDiagonal(largest), raised);
  backend.Axpby(1.0, diag_h, 1.0, raised);
  if (backend.CountNonPositive(raised) == 0 || !(largest > 0)) return {};
  std::vector<S> host(static_cast<std::size_t>(diag_h.size())), scratch(host.size());
  backend.ToHost(diag_h, {host.data(), diag_h.size()});
  RaiseDiagonal<S>(host, largest, scratch, [&](std::span<S> shares) {
    const std::vector<S> values = rounding_internal::SharesOfRows<B>(backend, batches);
    std::copy(values.begin(), values.end(), shares.begin());
  });
  backend.FromHost({host.data(), diag_h.size()}, raised);
  return raised;
}

}  // namespace vesta
