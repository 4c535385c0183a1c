// SPDX-License-Identifier: Apache-2.0
// Images of a splat, and products with their Jacobian.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/core/error.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "python/bindings/bindings.h"
#include "python/bindings/splats.h"
#include "splatting/render/look.h"

namespace vesta::python {

namespace {

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

// One splat in several views, each built when it is needed. The arrays of images have the shape (views, height, width,
// 3).
class Rasterization {
 public:
  Rasterization(const py::dict& splat, const std::vector<Doubles>& viewmats, const std::vector<Doubles>& Ks, int width,
                int height, double near, const std::array<double, 3>& background)
      : model_(ToModel(splat)), kernel_model_(gs::ToKernelModel(model_)), background_(background) {
    for (std::size_t i = 0; i < Ks.size(); ++i) {
      gs::View view = ToView(Ks[i], viewmats[i], width, height);
      view.camera.eps2d = model_.eps2d, view.camera.antialiased = model_.antialiased;
      gs::Scene frame;
      frame.origin = model_.origin;
      gs::MoveToScene(frame, &view);
      cameras_.push_back(gs::ToPosedCamera(view, near));
    }
  }

  Floats Colors() {
    Floats result(Shape(3));
    ForEachView([&](std::size_t v) {
      splats_.Render(planes_.data());
      FromPlanes(planes_, result.mutable_data() + v * Values());
    });
    return result;
  }
  // Per pixel, with the weights that blend the colours: the weighted sum of the depths of the Gaussians' centres along
  // the optical axis, and the opacity, which is the sum of the weights. Each (views, height, width).
  py::tuple DepthAndAlpha() {
    Floats depth(Shape(0)), alpha(Shape(0));
    ForEachView([&](std::size_t v) {
      const splat::PosedCamera& camera = cameras_[v];
      const std::vector<float> sums = gs::Blend(splats_, workspace_, [&](Index i) {
        double z = 0;
        for (int c = 0; c < 3; ++c) {
          const double mean = static_cast<double>(kernel_model_.x[(splat::kMean + c) * kernel_model_.count + i]);
          z += static_cast<double>(camera.R[6 + c]) * (mean - static_cast<double>(camera.centre[c]));
        }
        return std::array<float, 3>{static_cast<float>(z), 1, 0};
      });
      const auto pixels = static_cast<std::ptrdiff_t>(Values() / 3);
      std::copy_n(sums.begin(), pixels, depth.mutable_data() + static_cast<std::ptrdiff_t>(v) * pixels);
      std::copy_n(sums.begin() + pixels, pixels, alpha.mutable_data() + static_cast<std::ptrdiff_t>(v) * pixels);
    });
    return py::make_tuple(depth, alpha);
  }
  // J^T of all views: arrays like the splat's.
  py::dict Vjp(const Floats& d_colors) {
    CheckShape(d_colors);
    gs::SplatModel gradient = model_;
    std::ranges::fill(gradient.data, 0.0f);
    std::vector<float> image(Values());
    ForEachView([&](std::size_t v) {
      splats_.Render(image.data());
      ToPlanes(d_colors.data() + v * Values(), planes_);
      splats_.AddJT(kernel_model_, image.data(), planes_.data(), gradient.data.data(), workspace_);
    });
    return ToArrays(gradient);
  }
  // J of all views. d_splat: arrays like the splat's.
  Floats Jvp(const py::dict& d_splat) {
    const gs::SplatModel direction = ToModel(d_splat);
    if (direction.data.size() != model_.data.size())
      throw Error(kBadArgument, "jvp: the arrays differ from the splat's");
    Floats result(Shape(3));
    ForEachView([&](std::size_t v) {
      splats_.ApplyJ(kernel_model_, direction.data.data(), planes_.data(), workspace_);
      FromPlanes(planes_, result.mutable_data() + v * Values());
    });
    return result;
  }

 private:
  std::size_t Values() const {
    return 3 * static_cast<std::size_t>(cameras_[0].width) * static_cast<std::size_t>(cameras_[0].height);
  }
  std::vector<py::ssize_t> Shape(int channels) const {
    std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(cameras_.size())};
    if (!cameras_.empty()) shape.insert(shape.end(), {cameras_[0].height, cameras_[0].width});
    if (channels > 0) shape.push_back(channels);
    return shape;
  }
  void CheckShape(const Floats& colors) const {
    const std::vector<py::ssize_t> shape = Shape(3);
    if (!std::equal(shape.begin(), shape.end(), colors.shape(), colors.shape() + colors.ndim())) {
      throw Error(kBadArgument, "vjp needs an array with the shape of colors");
    }
  }
  // Builds each view, and calls work(view) without the GIL.
  template <class Work>
  void ForEachView(const Work& work) {
    const py::gil_scoped_release release;
    for (std::size_t v = 0; v < cameras_.size(); ++v) {
      planes_.resize(Values());
      splats_.Build(kernel_model_, cameras_[v], background_.data(), workspace_);
      work(v);
    }
  }
  static void FromPlanes(const std::vector<float>& planes, float* pixels) {
    const std::size_t count = planes.size() / 3;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t c = 0; c < 3; ++c) pixels[3 * i + c] = planes[c * count + i];
    }
  }
  static void ToPlanes(const float* pixels, std::vector<float>& planes) {
    const std::size_t count = planes.size() / 3;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t c = 0; c < 3; ++c) planes[c * count + i] = pixels[3 * i + c];
    }
  }

  gs::SplatModel model_;
  splat::Model<float> kernel_model_;  // refers to model_
  std::array<double, 3> background_;
  std::vector<splat::PosedCamera> cameras_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
  std::vector<float> planes_;
};

}  // namespace

void AddRasterization(py::module_& module) {
  py::class_<Rasterization>(module, "Rasterization")
      .def(py::init<const py::dict&, const std::vector<Doubles>&, const std::vector<Doubles>&, int, int, double,
                    const std::array<double, 3>&>())
      .def("colors", &Rasterization::Colors)
      .def("depth_and_alpha", &Rasterization::DepthAndAlpha)
      .def("vjp", &Rasterization::Vjp)
      .def("jvp", &Rasterization::Jvp);
}

}  // namespace vesta::python
