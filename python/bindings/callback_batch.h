// SPDX-License-Identifier: Apache-2.0
// Residuals computed by a Python function, one call for all rows of a batch.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

#include "problems/program/batch.h"

namespace vesta::python {

namespace py = pybind11;

// Calls function(x, derivatives), which returns (residuals, jacobians): residuals of shape (num_rows, num_residuals),
// and a list with one array of shape (num_rows, num_residuals, block size) per block, or None without derivatives.
// An exception of the function ends the solve and reaches its caller.
class CallbackBatch final : public program::Batch {
 public:
  CallbackBatch(py::function function, Index num_rows, int num_residuals, std::vector<int> block_sizes);
  ~CallbackBatch() override;

  void Evaluate(program::ConstVectorView x, bool jacobians) override;
  bool CopyRow(Index row, double* residuals, double** jacobians) const override;

 private:
  py::function function_;
  Index num_rows_;
  int num_residuals_;
  std::vector<int> block_sizes_;
  std::vector<double> residuals_;
  std::vector<std::vector<double>> jacobians_;  // per block
};

}  // namespace vesta::python
