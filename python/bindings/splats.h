// SPDX-License-Identifier: Apache-2.0
// Splats as numpy arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::python {

namespace py = pybind11;

// The arrays of a splat, with the names and shapes of vesta.Splat, in the order of the model.
py::dict ToArrays(const gs::SplatModel& model);
// The inverse, with one SH degree for all Gaussians. Throws Error if shapes do not fit each other.
gs::SplatModel ToModel(const py::dict& arrays);

// A camera without a photograph. K: 3 x 3; viewmat: 4 x 4, world to camera. Throws Error for other shapes, or if K has
// entries that a pinhole camera without skew lacks.
gs::View ToView(const py::array_t<double>& K, const py::array_t<double>& viewmat, int width, int height);

}  // namespace vesta::python
