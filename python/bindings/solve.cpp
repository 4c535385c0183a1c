// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/solve.h"

#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/error.h"
#include "solver/check_problem.h"
#include "solver/covariance.h"
#include "solver/evaluate.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::python {

namespace py = pybind11;

namespace {

LinearSolverKind SolverNamed(const std::string& name) {
  using enum LinearSolverKind;
  for (const auto& [known, kind] :
       {std::pair{"auto", kAuto}, {"pcg", kPcg}, {"schur_pcg", kReducedPcg}, {"lsmr", kLsmr}, {"dense_qr", kDenseQr}}) {
    if (name == known) return kind;
  }
  throw Error(kBadArgument,
              fmt::format("linear_solver is \"{}\"; the solvers are auto, pcg, schur_pcg, lsmr and dense_qr", name));
}

ColumnScaling ScalingNamed(const std::string& name) {
  using enum ColumnScaling;
  for (const auto& [known, scaling] :
       {std::pair{"inverse_root", kInverseRoot}, {"one_plus_inverse", kOnePlusInverse}, {"none", kNone}}) {
    if (name == known) return scaling;
  }
  throw Error(kBadArgument,
              fmt::format("column_scaling is \"{}\"; it can be inverse_root, one_plus_inverse or none", name));
}

}  // namespace

std::string NameOf(LmStatus status) {
  switch (status) {
    case LmStatus::kFunctionTolerance:
      return "function_tolerance";
    case LmStatus::kGradientTolerance:
      return "gradient_tolerance";
    case LmStatus::kParameterTolerance:
      return "parameter_tolerance";
    case LmStatus::kMaxIterations:
      return "max_iterations";
    case LmStatus::kTimeLimit:
      return "time_limit";
    case LmStatus::kStoppedByCallback:
      return "callback";
    case LmStatus::kNoDecrease:
      return "no_decrease";
    default:
      return "failed";
  }
}

LmOptions ToOptions(const py::dict& settings) {
  LmOptions options;
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    if (name == "max_iterations") {
      options.max_iterations = value.cast<int>();
    } else if (name == "function_tolerance") {
      options.function_tolerance = value.cast<double>();
    } else if (name == "gradient_tolerance") {
      options.gradient_tolerance = value.cast<double>();
    } else if (name == "parameter_tolerance") {
      options.parameter_tolerance = value.cast<double>();
    } else if (name == "max_seconds") {
      options.max_seconds = value.cast<double>();
    } else if (name == "initial_damping") {
      options.step_control.initial_lambda = value.cast<double>();
    } else if (name == "column_scaling") {
      options.column_scaling = ScalingNamed(value.cast<std::string>());
    } else if (name == "linear_solver") {
      options.normal_system.linear_solver = SolverNamed(value.cast<std::string>());
    } else {
      throw Error(kBadArgument, fmt::format("solve has no option \"{}\"", name));
    }
  }
  options.Validate();
  return options;
}

namespace {

// A row of the history, as a numpy structured type.
struct IterationRow {
  std::int64_t iteration;
  double cost, cost_change, gain_ratio, damping, gradient_max_norm, step_norm;
  std::int64_t pcg_iterations;
  bool accepted;
  double seconds;
};

IterationRow RowOf(const LmIteration& row) {
  return {row.iteration,         row.cost,      row.cost_change,    row.rho,      row.lambda,
          row.gradient_max_norm, row.step_norm, row.pcg_iterations, row.accepted, row.seconds};
}

template <class T>
py::array_t<T> ToArray(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

}  // namespace

py::dict ToDict(const LmSummary& summary) {
  std::vector<IterationRow> rows;
  for (const LmIteration& row : summary.iterations) rows.push_back(RowOf(row));
  py::dict result;
  result["status"] = NameOf(summary.status);
  result["converged"] = IsConverged(summary.status);
  result["failed"] = IsFailure(summary.status);
  result["message"] = summary.message;
  result["initial_cost"] = summary.initial_cost;
  result["final_cost"] = summary.final_cost;
  result["num_parameters"] = summary.num_parameters;
  result["num_residuals"] = summary.num_residuals;
  result["num_accepted"] = summary.num_accepted;
  result["num_rejected"] = summary.num_rejected;
  result["num_linearizations"] = summary.num_linearizations;
  result["num_cost_evaluations"] = summary.num_cost_evaluations;
  result["seconds"] = summary.total_seconds;
  result["linear_solver"] = summary.linear_solver;
  result["iterations"] = ToArray(rows);
  result["brief_report"] = summary.BriefReport();
  result["full_report"] = summary.FullReport();
  return result;
}

LmCallback MakeCallback(const py::object& callback) {
  return [&callback](const LmIteration& row) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback.is_none()) return CallbackResult::kContinue;
    const py::object result = callback(ToArray(std::vector<IterationRow>{RowOf(row)}).attr("__getitem__")(0));
    return result.is(py::bool_(false)) ? CallbackResult::kStop : CallbackResult::kContinue;
  };
}

namespace {

py::dict Solve(program::BatchProblem& problem, const py::dict& settings, const py::object& callback) {
  const LmOptions options = ToOptions(settings);
  LmSummary summary;
  {
    const py::gil_scoped_release release;
    summary = SolveLm(problem.blocks(), options, MakeCallback(callback));
  }
  return ToDict(summary);
}

py::dict EvaluateProblem(program::BatchProblem& problem, bool apply_loss, bool derivatives) {
  BlockEvaluation evaluation;
  {
    const py::gil_scoped_release release;
    const auto x = problem.blocks().Gather();
    EvaluateOptions options;
    options.apply_loss = apply_loss;
    options.derivatives = derivatives;
    evaluation = Evaluate(problem.blocks(), x.view(), options);
  }
  py::dict result;
  result["cost"] = evaluation.cost;
  result["residuals"] = ToArray(evaluation.residuals);
  if (!derivatives) return result;
  result["gradient"] = ToArray(evaluation.gradient);
  const CrsMatrix& j = evaluation.jacobian;
  result["shape"] = py::make_tuple(j.rows, j.cols);
  result["row_starts"] = ToArray(j.row_starts);
  result["columns"] = ToArray(j.columns);
  result["values"] = ToArray(j.values);
  return result;
}

// One matrix per pair; None if one of the blocks is constant or unused.
py::list CovarianceOf(program::BatchProblem& problem, const std::vector<std::pair<int, int>>& pairs, bool ambient) {
  BlockCovariance covariance;
  {
    const py::gil_scoped_release release;
    const auto x = problem.blocks().Gather();
    covariance = EstimateBlockCovariance(problem.blocks(), x.view(), pairs,
                                         ambient ? CovarianceSpace::kAmbient : CovarianceSpace::kTangent);
  }
  if (covariance.num_singular > 0) {
    throw Error(kBadArgument,
                fmt::format("no covariance: the residuals do not determine {} directions of the parameters; "
                            "hold some blocks constant",
                            covariance.num_singular));
  }
  py::list result;
  for (const BlockCovariance::Block& block : covariance.blocks) {
    if (block.values.empty()) {
      result.append(py::none());
    } else {
      result.append(py::array_t<double>({block.rows, block.cols}, block.values.data()));
    }
  }
  return result;
}

std::vector<std::string> Check(program::BatchProblem& problem) {
  const py::gil_scoped_release release;
  const auto x = problem.blocks().Gather();
  CpuBackend<double> backend;
  return CheckProblem<CpuBackend<double>>(backend, problem.blocks(), x.view()).faults;
}

}  // namespace

void AddSolve(py::class_<program::BatchProblem>& problem) {
  PYBIND11_NUMPY_DTYPE(IterationRow, iteration, cost, cost_change, gain_ratio, damping, gradient_max_norm, step_norm,
                       pcg_iterations, accepted, seconds);
  problem.def("solve", &Solve, py::arg("options"), py::arg("callback").none(true))
      .def("evaluate", &EvaluateProblem, py::arg("apply_loss"), py::arg("derivatives"))
      .def("covariance", &CovarianceOf, py::arg("pairs"), py::arg("ambient"))
      .def("check", &Check);
}

}  // namespace vesta::python
