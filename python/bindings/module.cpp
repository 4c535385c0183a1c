// SPDX-License-Identifier: Apache-2.0
// The extension module vesta._vesta. Each file of this folder adds one group of classes and functions.
#include <pybind11/pybind11.h>

#include "kernels/core/error.h"
#include "kernels/core/parallel.h"
#include "python/bindings/bindings.h"

namespace vesta::python {
namespace {

// Error as the Python exception that fits its code; the message is the same line.
void RaiseFor(const Error& error) {
  switch (error.code()) {
    case kBadArgument:
    case kBadFile:
    case kUnsupported:
      PyErr_SetString(PyExc_ValueError, error.what());
      return;
    case kNotFound:
      PyErr_SetString(PyExc_FileNotFoundError, error.what());
      return;
    case kCannotWrite:
      PyErr_SetString(PyExc_OSError, error.what());
      return;
    case kOutOfMemory:
      PyErr_SetString(PyExc_MemoryError, error.what());
      return;
    case kUnavailable:
      PyErr_SetString(PyExc_RuntimeError, error.what());
      return;
  }
}

}  // namespace

PYBIND11_MODULE(_vesta, module) {
  module.doc() = "The compiled part of the package vesta.";
  py::register_exception_translator(
      [](std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param): the type of pybind11
        try {
          if (thrown) std::rethrow_exception(thrown);
        } catch (const Error& error) {
          RaiseFor(error);
        }
      });
  module.def("set_num_threads", &SetNumThreads, py::arg("num_threads"),
             "Sets the number of threads; 0 means one per core.");
  module.def("num_threads", &NumThreads, "The number of threads.");
  AddProblem(module);
  AddOperators(module);
  AddSolveEach(module);
  AddSplats(module);
  AddScene(module);
  AddRasterization(module);
}

}  // namespace vesta::python
