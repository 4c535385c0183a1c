// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/callback_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "kernels/core/error.h"

namespace vesta::python {

namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Copies an array with this many numbers.
void CopyFrom(const py::handle& object, Index size, const std::string& what, std::vector<double>& to) {
  const Array array = Array::ensure(object);
  if (!array) throw py::error_already_set();
  if (array.size() != size) {
    throw Error(kBadArgument,
                fmt::format("the function returned {} with {} numbers, not {}", what, array.size(), size));
  }
  to.assign(array.data(), array.data() + size);
}

}  // namespace

CallbackBatch::CallbackBatch(py::function function, Index num_rows, int num_residuals, std::vector<int> block_sizes)
    : function_(std::move(function)),
      num_rows_(num_rows),
      num_residuals_(num_residuals),
      block_sizes_(std::move(block_sizes)),
      jacobians_(block_sizes_.size()) {}

CallbackBatch::~CallbackBatch() {
  const py::gil_scoped_acquire gil;
  function_ = py::function();
}

void CallbackBatch::Evaluate(program::ConstVectorView x, bool jacobians) {
  const py::gil_scoped_acquire gil;
  const py::array_t<double> values(static_cast<py::ssize_t>(x.size()), x.data());
  const py::tuple result = function_(values, jacobians);
  CopyFrom(result[0], num_rows_ * num_residuals_, "residuals", residuals_);
  if (!jacobians) return;
  const py::sequence blocks = result[1];
  if (blocks.size() != block_sizes_.size()) {
    throw Error(kBadArgument, fmt::format("the function returned Jacobians for {} blocks, not {}", blocks.size(),
                                          block_sizes_.size()));
  }
  for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
    CopyFrom(blocks[b], num_rows_ * num_residuals_ * block_sizes_[b], fmt::format("a Jacobian for block {}", b),
             jacobians_[b]);
  }
}

bool CallbackBatch::CopyRow(Index row, double* residuals, double** jacobians) const {
  std::copy_n(residuals_.data() + row * num_residuals_, num_residuals_, residuals);
  if (jacobians == nullptr) return true;
  for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
    const Index size = Index{num_residuals_} * block_sizes_[b];
    if (jacobians[b] != nullptr) std::copy_n(jacobians_[b].data() + row * size, size, jacobians[b]);
  }
  return true;
}

}  // namespace vesta::python
