// SPDX-License-Identifier: Apache-2.0
// Problems whose Jacobian is only known by its products, computed by Python functions.
#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "kernels/core/error.h"
#include "kernels/core/random.h"
#include "python/bindings/bindings.h"
#include "python/bindings/solve.h"
#include "solver/levenberg_marquardt.h"
#include "solver/problem.h"

namespace vesta::python {

namespace {

using B = CpuBackend<double>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::array_t<double> ToArray(B::ConstVectorView v) {
  return py::array_t<double>(static_cast<py::ssize_t>(v.size()), v.data());
}

// Calls a method of one array, and copies its result, which must have to.size() numbers.
void Call(const py::object& object, const char* method, B::ConstVectorView argument, const char* what,
          B::VectorView to) {
  const py::gil_scoped_acquire gil;
  const Doubles result = Doubles::ensure(object.attr(method)(ToArray(argument)));
  if (!result) throw py::error_already_set();
  if (result.size() != to.size()) {
    throw Error(kBadArgument, fmt::format("{} returned {} numbers, not {}", what, result.size(), to.size()));
  }
  std::copy_n(result.data(), result.size(), to.data());
}

// An object of Python's that is released with the GIL held.
class Held {
 public:
  explicit Held(py::object object) : object_(std::move(object)) {}
  ~Held() {
    const py::gil_scoped_acquire gil;
    object_ = py::object();
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  const py::object& get() const { return object_; }

 private:
  py::object object_;
};

// jacobian: has matvec and rmatvec, as scipy's LinearOperator, and possibly diag_jtj, the diagonal of J^T J.
class OperatorLinearization final : public Linearization<B> {
 public:
  OperatorLinearization(const py::object& fun, const py::object& jac, B::ConstVectorView x, Index num_residuals)
      : num_parameters_(x.size()), residuals_(num_residuals), jacobian_(Operator(jac, x)) {
    Call(fun, "__call__", x, "fun", residuals_.view());
  }
  Index num_residuals() const override { return residuals_.size(); }
  Index num_parameters() const override { return num_parameters_; }
  B::ConstVectorView residuals() const override { return residuals_.view(); }
  void ApplyJ(B::ConstVectorView v, B::VectorView u) override { Call(jacobian_->get(), "matvec", v, "matvec", u); }
  void ApplyJT(B::ConstVectorView u, B::VectorView g) override { Call(jacobian_->get(), "rmatvec", u, "rmatvec", g); }
  void DiagJTJ(B::VectorView d) override {
    {
      const py::gil_scoped_acquire gil;
      if (py::hasattr(jacobian_->get(), "diag_jtj")) {
        const Doubles diagonal = Doubles::ensure(jacobian_->get().attr("diag_jtj"));
        if (!diagonal || diagonal.size() != d.size()) {
          throw Error(kBadArgument, fmt::format("diag_jtj needs {} numbers", d.size()));
        }
        std::copy_n(diagonal.data(), d.size(), d.data());
        return;
      }
    }
    // Their mean, by |J z|^2 for a vector z of signs.
    B::Vector z(num_parameters_), product(num_residuals());
    constexpr int kProbes = 4;
    double sum = 0;
    CounterRandom random(1, 0);
    for (int probe = 0; probe < kProbes; ++probe) {
      for (Index k = 0; k < z.size(); ++k) z[k] = random.Uniform() < 0.5 ? -1 : 1;
      ApplyJ(z.view(), product.view());
      sum += B().Dot(product.view(), product.view());
    }
    std::fill_n(d.data(), d.size(), sum / kProbes / static_cast<double>(num_parameters_));
  }

 private:
  static std::unique_ptr<Held> Operator(const py::object& jac, B::ConstVectorView x) {
    const py::gil_scoped_acquire gil;
    return std::make_unique<Held>(jac(ToArray(x)));
  }

  Index num_parameters_;
  B::Vector residuals_;
  std::unique_ptr<Held> jacobian_;
};

class OperatorProblem final : public Problem<B> {
 public:
  OperatorProblem(py::object fun, py::object jac, Index num_parameters, Index num_residuals)
      : fun_(std::move(fun)), jac_(std::move(jac)), num_parameters_(num_parameters), residuals_(num_residuals) {}
  Index num_parameters() const override { return num_parameters_; }
  double Cost(B::ConstVectorView x) override {
    Call(fun_.get(), "__call__", x, "fun", residuals_.view());
    return 0.5 * B().Dot(residuals_.view(), residuals_.view());
  }
  std::unique_ptr<Linearization<B>> Linearize(B::ConstVectorView x) override {
    return std::make_unique<OperatorLinearization>(fun_.get(), jac_.get(), x, residuals_.size());
  }

 private:
  Held fun_, jac_;
  Index num_parameters_;
  B::Vector residuals_;
};

// Returns the solution and the summary.
py::tuple SolveOperators(py::object fun, py::object jac, const Doubles& x0, Index num_residuals,
                         const py::dict& settings, const py::object& callback) {
  const LmOptions options = ToOptions(settings);
  OperatorProblem problem(std::move(fun), std::move(jac), x0.size(), num_residuals);
  B::Vector x(x0.size());
  std::copy_n(x0.data(), x0.size(), x.data());
  LmSummary summary;
  {
    const py::gil_scoped_release release;
    summary = SolveLm<B>(problem, x.view(), options, MakeCallback(callback));
  }
  return py::make_tuple(ToArray(x.view()), ToDict(summary));
}

}  // namespace

void AddOperators(py::module_& module) {
  module.def("solve_operators", &SolveOperators, py::arg("fun"), py::arg("jac"), py::arg("x0"),
             py::arg("num_residuals"), py::arg("options"), py::arg("callback").none(true));
}

}  // namespace vesta::python
