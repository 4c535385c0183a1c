// SPDX-License-Identifier: Apache-2.0
// vesta._vesta.Problem: parameter blocks, and residuals as programs or Python functions.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "kernels/core/error.h"
#include "problems/program/batch.h"
#include "python/bindings/bindings.h"
#include "python/bindings/callback_batch.h"
#include "python/bindings/solve.h"
#include "solver/loss.h"
#include "solver/manifold.h"

namespace vesta::python {

namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<int, py::array::c_style | py::array::forcecast>;

template <class Array>
auto SpanOf(const Array& array) {
  return std::span(array.data(), static_cast<std::size_t>(array.size()));
}

// Adds one block per row of `values`, shape (count, size). Returns the index of the first.
int AddBlocks(program::BatchProblem& problem, const Doubles& values, const std::shared_ptr<Manifold>& manifold) {
  if (values.ndim() != 2) throw Error(kBadArgument, "values of parameter blocks need the shape (blocks, numbers)");
  const int count = static_cast<int>(values.shape(0)), size = static_cast<int>(values.shape(1));
  int first = -1;
  for (int i = 0; i < count; ++i) {
    const int block = problem.blocks().AddParameterBlock(size, manifold);
    problem.blocks().Set(block, values.data(i, 0));
    if (i == 0) first = block;
  }
  return first;
}

program::Program MakeProgram(int num_inputs, const std::vector<std::tuple<std::string, int, int, int, double>>& list,
                             std::vector<int> outputs) {
  program::Program result{.num_inputs = num_inputs, .instructions = {}, .outputs = std::move(outputs)};
  for (const auto& [name, a, b, c, value] : list) {
    result.instructions.push_back({program::OperationNamed(name), a, b, c, value});
  }
  program::Check(result);
  // Without repeated instructions.
  program::ProgramBuilder builder(num_inputs);
  std::vector<int> at;
  const auto moved = [&](int position) { return position < 0 ? -1 : at[static_cast<std::size_t>(position)]; };
  for (const program::Instruction& i : result.instructions) {
    if (i.operation == program::Operation::kInput) {
      at.push_back(builder.Input(i.a));
    } else if (i.operation == program::Operation::kConstant) {
      at.push_back(builder.Constant(i.value));
    } else {
      at.push_back(builder.Add(i.operation, moved(i.a), moved(i.b), moved(i.c)));
    }
  }
  for (int& output : result.outputs) output = moved(output);
  return builder.Finish(result.outputs);
}

void AddProgram(program::BatchProblem& problem, const program::Program& residuals, const std::vector<int>& block_sizes,
                const Integers& blocks, const Doubles& data, const std::shared_ptr<Loss>& loss) {
  const py::gil_scoped_release release;
  auto batch =
      std::make_shared<program::ProgramBatch>(problem.blocks(), residuals, block_sizes, SpanOf(blocks), SpanOf(data));
  const Index num_rows = batch->num_rows();
  problem.Add(std::move(batch), num_rows, static_cast<int>(residuals.outputs.size()), block_sizes, SpanOf(blocks),
              loss);
}

void AddCallback(program::BatchProblem& problem, py::function function, int num_residuals,
                 const std::vector<int>& block_sizes, const Integers& blocks, const std::shared_ptr<Loss>& loss) {
  if (block_sizes.empty()) throw Error(kBadArgument, "residuals need at least one parameter block");
  const auto num_rows = static_cast<Index>(blocks.size() / static_cast<py::ssize_t>(block_sizes.size()));
  problem.Add(std::make_shared<CallbackBatch>(std::move(function), num_rows, num_residuals, block_sizes), num_rows,
              num_residuals, block_sizes, SpanOf(blocks), loss);
}

void AddLosses(py::module_& module) {
  const py::class_<Loss, std::shared_ptr<Loss>> base(module, "Loss");
  const auto scaled = [&]<class L>(const char* name, const L*) {
    py::class_<L, Loss, std::shared_ptr<L>>(module, name).def(py::init<double>(), py::arg("a"));
  };
  scaled("HuberLoss", static_cast<const HuberLoss*>(nullptr));
  scaled("SoftLOneLoss", static_cast<const SoftLOneLoss*>(nullptr));
  scaled("CauchyLoss", static_cast<const CauchyLoss*>(nullptr));
  scaled("ArctanLoss", static_cast<const ArctanLoss*>(nullptr));
  scaled("TukeyLoss", static_cast<const TukeyLoss*>(nullptr));
  py::class_<TolerantLoss, Loss, std::shared_ptr<TolerantLoss>>(module, "TolerantLoss")
      .def(py::init<double, double>(), py::arg("a"), py::arg("b"));
  py::class_<ScaledLoss, Loss, std::shared_ptr<ScaledLoss>>(module, "ScaledLoss")
      .def(py::init([](const std::shared_ptr<Loss>& loss, double weight) {
             return std::make_shared<ScaledLoss>(loss, weight);
           }),
           py::arg("loss").none(true), py::arg("weight"));
}

void AddManifolds(py::module_& module) {
  py::class_<Manifold, std::shared_ptr<Manifold>>(module, "Manifold")
      .def_property_readonly("ambient_size", &Manifold::ambient_size)
      .def_property_readonly("tangent_size", &Manifold::tangent_size)
      .def("plus",
           [](const Manifold& manifold, const std::vector<double>& x, const std::vector<double>& delta) {
             if (static_cast<int>(x.size()) != manifold.ambient_size() ||
                 static_cast<int>(delta.size()) != manifold.tangent_size()) {
               throw Error(kBadArgument, "plus: x or delta has the wrong size");
             }
             py::array_t<double> out(static_cast<py::ssize_t>(x.size()));
             manifold.Plus(x.data(), delta.data(), out.mutable_data());
             return out;
           })
      .def("plus_jacobian", [](const Manifold& manifold, const std::vector<double>& x) {
        if (static_cast<int>(x.size()) != manifold.ambient_size()) {
          throw Error(kBadArgument, "plus_jacobian: x has the wrong size");
        }
        py::array_t<double> out({manifold.ambient_size(), manifold.tangent_size()});
        manifold.PlusJacobian(x.data(), out.mutable_data());
        return out;
      });
  const auto order = [](bool scalar_first) {
    return scalar_first ? QuaternionManifold::Order::kWxyz : QuaternionManifold::Order::kXyzw;
  };
  py::class_<QuaternionManifold, Manifold, std::shared_ptr<QuaternionManifold>>(module, "QuaternionManifold")
      .def(py::init([order](bool first) { return std::make_shared<QuaternionManifold>(order(first)); }),
           py::arg("scalar_first") = true);
  py::class_<Se3Manifold, Manifold, std::shared_ptr<Se3Manifold>>(module, "Se3Manifold")
      .def(py::init([order](bool first) { return std::make_shared<Se3Manifold>(order(first)); }),
           py::arg("scalar_first") = true);
  const auto sized = [&]<class M>(const char* name, const M*) {
    py::class_<M, Manifold, std::shared_ptr<M>>(module, name).def(py::init<int>(), py::arg("size"));
  };
  sized("UnitVectorManifold", static_cast<const UnitVectorManifold*>(nullptr));
  sized("LineManifold", static_cast<const LineManifold*>(nullptr));
  sized("EuclideanManifold", static_cast<const EuclideanManifold*>(nullptr));
  py::class_<SubsetManifold, Manifold, std::shared_ptr<SubsetManifold>>(module, "SubsetManifold")
      .def(py::init<int, std::vector<int>>(), py::arg("size"), py::arg("constant"));
  py::class_<ProductManifold, Manifold, std::shared_ptr<ProductManifold>>(module, "ProductManifold")
      .def(py::init([](const std::vector<std::shared_ptr<Manifold>>& parts) {
             return std::make_shared<ProductManifold>(
                 std::vector<std::shared_ptr<const Manifold>>(parts.begin(), parts.end()));
           }),
           py::arg("parts"));
}

}  // namespace

void AddProblem(py::module_& module) {
  AddLosses(module);
  AddManifolds(module);
  py::class_<program::Program>(module, "Program")
      .def(py::init(&MakeProgram), py::arg("num_inputs"), py::arg("instructions"), py::arg("outputs"))
      .def_property_readonly("num_instructions",
                             [](const program::Program& program) { return program.instructions.size(); });
  auto problem = py::class_<program::BatchProblem>(module, "Problem")
                     .def(py::init<>())
                     .def("add_blocks", &AddBlocks, py::arg("values"), py::arg("manifold").none(true))
                     .def("add_program", &AddProgram, py::arg("program"), py::arg("block_sizes"), py::arg("blocks"),
                          py::arg("data"), py::arg("loss").none(true))
                     .def("add_callback", &AddCallback, py::arg("function"), py::arg("num_residuals"),
                          py::arg("block_sizes"), py::arg("blocks"), py::arg("loss").none(true))
                     .def("set_constant", [](program::BatchProblem& p, int block,
                                             bool constant) { p.blocks().SetConstant(block, constant); })
                     .def("set_bounds", [](program::BatchProblem& p, int block, int entry, double lower,
                                           double upper) { p.blocks().SetBounds(block, entry, lower, upper); })
                     .def("get_values",
                          [](program::BatchProblem& p) {
                            const auto x = p.blocks().Gather();
                            return py::array_t<double>(static_cast<py::ssize_t>(x.size()), x.data());
                          })
                     .def("set_values",
                          [](program::BatchProblem& p, const Doubles& x) {
                            if (x.size() != p.blocks().num_parameters())
                              throw Error(kBadArgument, "set_values: wrong size");
                            p.blocks().Scatter({x.data(), x.size()});
                          })
                     .def_property_readonly("num_parameters",
                                            [](program::BatchProblem& p) { return p.blocks().num_parameters(); });
  AddSolve(problem);
}

}  // namespace vesta::python
