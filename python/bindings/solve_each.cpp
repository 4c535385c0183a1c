// SPDX-License-Identifier: Apache-2.0
#include "problems/program/solve_each.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/error.h"
#include "python/bindings/bindings.h"
#include "python/bindings/solve.h"

namespace vesta::python {

namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

// x: (problems, parameters). data: one array (problems, residuals) per datum. Returns x, costs, statuses and numbers of
// iterations.
py::tuple SolveEach(const program::Program& residual, const Doubles& x, const std::vector<Doubles>& data,
                    int num_residuals, const py::dict& settings) {
  if (x.ndim() != 2) throw Error(kBadArgument, "x0 needs the shape (problems, parameters)");
  const LmOptions options = ToOptions(settings);
  std::vector<double> result(x.data(), x.data() + x.size());
  program::EachProblem problem{
      .num_parameters = static_cast<int>(x.shape(1)), .num_residuals = num_residuals, .residual = residual, .data = {}};
  for (const Doubles& array : data) problem.data.emplace_back(array.data(), static_cast<std::size_t>(array.size()));
  std::vector<SmallSummary> summaries;
  {
    const py::gil_scoped_release release;
    summaries = program::SolveEach(problem, result, options);
  }
  const auto count = static_cast<py::ssize_t>(summaries.size());
  py::array_t<double> costs(count);
  py::array_t<int> iterations(count);
  py::array_t<bool> converged(count);
  py::list statuses;
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    const SmallSummary& summary = summaries[i];
    costs.mutable_data()[i] = summary.final_cost;
    iterations.mutable_data()[i] = summary.num_accepted + summary.num_rejected;
    converged.mutable_data()[i] = IsConverged(summary.status);
    statuses.append(NameOf(summary.status));
  }
  return py::make_tuple(py::array_t<double>({x.shape(0), x.shape(1)}, result.data()), costs, statuses, iterations,
                        converged);
}

}  // namespace

void AddSolveEach(py::module_& module) {
  module.attr("max_each_parameters") = program::kMaxEachParameters;
  module.def("solve_each", &SolveEach, py::arg("residual"), py::arg("x0"), py::arg("data"), py::arg("num_residuals"),
             py::arg("options"));
}

}  // namespace vesta::python
