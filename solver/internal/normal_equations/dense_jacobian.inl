// SPDX-License-Identifier: Apache-2.0
// Body of solver/internal/normal_equations/dense_jacobian.h.
#pragma once

#include <algorithm>
#include <limits>

#include "kernels/core/check.h"
#include "solver/internal/normal_equations/dense_jacobian.h"

namespace vesta {

template <Backend B>
DenseJacobian MakeDenseJacobian(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView mask) {
  using S = typename B::Scalar;
  const Index cols = batches.front()->num_parameters();
  Index rows = 0;
  for (const LinearizationAdaptor<B>* batch : batches) rows += batch->num_residuals();
  VESTA_CHECK(rows <= std::numeric_limits<int>::max() && cols <= std::numeric_limits<int>::max(),
              "a dense Jacobian of {} x {}", rows, cols);
  DenseJacobian dense{.rows = static_cast<int>(rows), .cols = static_cast<int>(cols)};
  dense.residuals.resize(static_cast<std::size_t>(rows));
  dense.jacobian.resize(static_cast<std::size_t>(rows * cols));
  std::vector<S> host(static_cast<std::size_t>(std::max(rows, cols)));
  const auto fetch = [&](typename B::ConstVectorView from, double* to) {
    backend.ToHost(from, {host.data(), from.size()});
    std::copy_n(host.begin(), from.size(), to);
  };
  std::vector<bool> masked(static_cast<std::size_t>(cols), false);
  if (!mask.empty()) {
    backend.ToHost(mask, {host.data(), cols});
    std::transform(host.begin(), host.begin() + cols, masked.begin(), [](S m) { return m == S(0); });
  }
  typename B::Vector unit(cols), column;
  Index row = 0;
  for (LinearizationAdaptor<B>* batch : batches) {
    column.Resize(batch->num_residuals());
    fetch(batch->residuals(), dense.residuals.data() + row);
    for (Index k = 0; k < cols; ++k) {
      if (masked[static_cast<std::size_t>(k)]) continue;
      backend.Fill(1, unit.view().subspan(k, 1));
      batch->ApplyJ(unit, column);
      backend.Fill(0, unit.view().subspan(k, 1));
      fetch(column, dense.jacobian.data() + k * rows + row);
    }
    row += batch->num_residuals();
  }
  return dense;
}

}  // namespace vesta
