// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/splats.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/error.h"
#include "kernels/math/quaternion.h"
#include "kernels/math/spherical_harmonics.h"
#include "python/bindings/bindings.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::python {

namespace {

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

// The arrays of geometric attributes: name, first attribute and numbers per Gaussian.
struct Column {
  const char* name;
  int first, count;
};
constexpr Column kColumns[] = {{"means", splat::kMean, 3},
                               {"log_scales", splat::kLogScale, 3},
                               {"quats", splat::kQuaternion, 4},
                               {"opacity_logits", splat::kOpacity, 1}};

Floats ArrayNamed(const py::dict& arrays, const char* name) {
  if (!arrays.contains(name)) throw Error(kBadArgument, fmt::format("the splat has no array {}", name));
  Floats array = Floats::ensure(arrays[name]);
  if (!array) throw py::error_already_set();
  return array;
}

}  // namespace

py::dict ToArrays(const gs::SplatModel& model) {
  py::dict result;
  const auto n = static_cast<py::ssize_t>(model.count);
  for (const Column& column : kColumns) {
    Floats array = column.count == 1 ? Floats(n) : Floats({n, py::ssize_t{column.count}});
    float* const to = array.mutable_data();
    for (int a = 0; a < column.count; ++a) {
      for (Index i = 0; i < model.count; ++i) to[i * column.count + a] = model.Value(column.first + a, i);
    }
    result[column.name] = array;
  }
  const int coefficients = (model.sh_degree + 1) * (model.sh_degree + 1);
  Floats sh({n, py::ssize_t{coefficients}, py::ssize_t{3}});
  for (int a = 0; a < 3 * coefficients; ++a) {
    for (Index i = 0; i < model.count; ++i) {
      sh.mutable_data()[i * 3 * coefficients + a] = model.Value(splat::kSh + a, i);
    }
  }
  result["sh"] = sh;
  if (model.has_background) {
    result["background"] = py::make_tuple(model.background[0], model.background[1], model.background[2]);
  }
  result["eps2d"] = model.eps2d;
  result["antialiased"] = model.antialiased;
  result["origin"] = py::make_tuple(model.origin[0], model.origin[1], model.origin[2]);
  return result;
}

gs::SplatModel ToModel(const py::dict& arrays) {
  const Floats sh = ArrayNamed(arrays, "sh");
  int degree = 0;
  while (degree < splat::kMaxShDegree && sh.ndim() == 3 && sh.shape(1) > (degree + 1) * (degree + 1)) ++degree;
  if (sh.ndim() != 3 || sh.shape(2) != 3 || sh.shape(1) != (degree + 1) * (degree + 1) || sh.shape(0) < 1) {
    throw Error(kBadArgument, "sh needs the shape (Gaussians, K, 3) with K = 1, 4, 9 or 16 and at least one Gaussian");
  }
  gs::SplatModel model;
  model.Resize(degree, sh.shape(0));
  for (const Column& column : kColumns) {
    const Floats array = ArrayNamed(arrays, column.name);
    if (array.size() != model.count * column.count || array.shape(0) != model.count) {
      throw Error(kBadArgument,
                  fmt::format("{} needs {} numbers for each of {} Gaussians", column.name, column.count, model.count));
    }
    for (int a = 0; a < column.count; ++a) {
      for (Index i = 0; i < model.count; ++i) {
        model.attribute(column.first + a)[i] = array.data()[i * column.count + a];
      }
    }
  }
  const Index values = 3 * sh.shape(1);
  for (int a = 0; a < values; ++a) {
    for (Index i = 0; i < model.count; ++i) model.attribute(splat::kSh + a)[i] = sh.data()[i * values + a];
  }
  if (arrays.contains("background")) {
    model.background = arrays["background"].cast<std::array<float, 3>>();
    model.has_background = true;
  }
  if (arrays.contains("eps2d")) model.eps2d = arrays["eps2d"].cast<double>();
  if (arrays.contains("antialiased")) model.antialiased = arrays["antialiased"].cast<bool>();
  if (arrays.contains("origin")) model.origin = arrays["origin"].cast<std::array<double, 3>>();
  return model;
}

gs::View ToView(const py::array_t<double>& K, const py::array_t<double>& viewmat, int width, int height) {
  if (K.ndim() != 2 || K.shape(0) != 3 || K.shape(1) != 3) throw Error(kBadArgument, "K needs the shape (3, 3)");
  if (viewmat.ndim() != 2 || viewmat.shape(0) != 4 || viewmat.shape(1) != 4) {
    throw Error(kBadArgument, "a view matrix needs the shape (4, 4)");
  }
  if (K.at(0, 1) != 0 || K.at(1, 0) != 0 || K.at(2, 0) != 0 || K.at(2, 1) != 0 || K.at(2, 2) != 1) {
    throw Error(kUnsupported, "K needs the form [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  }
  if (width < 1 || height < 1 || !(K.at(0, 0) > 0) || !(K.at(1, 1) > 0)) {
    throw Error(kBadArgument, "the image size and the focal lengths need to be positive");
  }
  gs::View view;
  view.camera = {.width = width,
                 .height = height,
                 .lens = {.fx = K.at(0, 0), .fy = K.at(1, 1), .cx = K.at(0, 2), .cy = K.at(1, 2)}};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) view.rotation[3 * r + c] = viewmat.at(r, c);
    view.translation[r] = viewmat.at(r, 3);
  }
  const auto& q = view.rotation;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t s = r; s < 3; ++s) {
      const double product = q[3 * r] * q[3 * s] + q[3 * r + 1] * q[3 * s + 1] + q[3 * r + 2] * q[3 * s + 2];
      if (!(std::abs(product - (r == s ? 1 : 0)) < 1e-4)) {
        throw Error(kBadArgument, "the first three columns of a view matrix need to be a rotation");
      }
    }
  }
  return view;
}

void AddSplats(py::module_& module) {
  // Spherical harmonics of degree 3 at unit directions (n, 3): shape (n, 16).
  module.def("sh_basis", [](const py::array_t<double>& directions) {
    const auto at = directions.unchecked<2>();
    py::array_t<double> result({at.shape(0), py::ssize_t{16}});
    for (py::ssize_t i = 0; i < at.shape(0); ++i) {
      ShBasis<3>(at(i, 0), at(i, 1), at(i, 2), result.mutable_data(i, 0));
    }
    return result;
  });
  module.def("quaternion_of", [](const py::array_t<double, py::array::c_style | py::array::forcecast>& rotation) {
    py::array_t<double> result(4);
    QuaternionFromRotation(rotation.data(), result.mutable_data());
    return result;
  });
  module.def("read_splat", [](const std::string& path) {
    std::vector<std::string> notes;
    gs::SplatModel model;
    {
      const py::gil_scoped_release release;
      model = gs::ReadSplat(path, &notes);
    }
    return py::make_tuple(ToArrays(model), notes);
  });
  module.def("write_splat", [](const std::string& path, const py::dict& arrays) {
    const gs::SplatModel model = ToModel(arrays);
    std::vector<std::string> notes;
    gs::WriteSplatOptions options;
    options.notes = &notes;
    {
      const py::gil_scoped_release release;
      gs::WriteSplat(path, model, options);
    }
    return notes;
  });
}

}  // namespace vesta::python
