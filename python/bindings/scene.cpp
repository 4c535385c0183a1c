// SPDX-License-Identifier: Apache-2.0
// vesta._vesta.Scene, and trainings and evaluations on it.
#include "problems/gaussian_splatting/scene/scene.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/error.h"
#include "kernels/core/process_memory.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "python/bindings/bindings.h"
#include "python/bindings/splats.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/prune_at_start.h"
#include "splatting/train/settings/train_options.h"
#include "splatting/train/trainer.h"

namespace vesta::python {

namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Texts = std::map<std::string, std::string>;

// Options by their names in `vesta config`, such as adam.iterations. kind: "train", "refine" or "prune".
gs::TrainOptions OptionsOf(const std::string& kind, const std::string& preset, const Texts& given) {
  gs::TrainOptions options = kind == "train"    ? gs::PresetOptions(preset)
                             : kind == "refine" ? gs::RefinePresetOptions(preset)
                                                : gs::PrunePresetOptions(preset);
  for (const auto& [name, text] : given) {
    const schema::Field<gs::TrainOptions>* const field = schema::Find(gs::TrainFields(), name);
    if (field == nullptr)
      throw Error(kBadArgument, fmt::format("there is no option {}; `vesta config` lists all", name));
    if (!field->Set(text, options))
      throw Error(kBadArgument, fmt::format("{}={}: {}", name, text, field->Requirement()));
  }
  gs::ValidateOptions(options);
  return options;
}

std::shared_ptr<gs::Scene> LoadScene(const std::string& path, int downscale, std::optional<int> test_every,
                                     const std::string& test_list, bool hold_out, const std::string& image_folder,
                                     bool allow_missing, std::optional<double> photographs_mib, std::uint64_t seed,
                                     const std::array<float, 3>& background, double eps2d, bool antialiased) {
  const py::gil_scoped_release release;
  gs::LoadSceneOptions options;
  options.downscale = downscale;
  options.test_views = {.every = test_every, .list = test_list};
  options.hold_out = hold_out;
  options.photographs_bytes = photographs_mib.value_or(0.5 * AvailableMemoryMib()) * 0x1p20;
  options.image_folder = image_folder;
  options.allow_missing = allow_missing;
  options.random_points.seed = seed;
  options.finds_points = true;
  options.background = background;
  options.eps2d = eps2d;
  options.antialiased = antialiased;
  return std::make_shared<gs::Scene>(gs::LoadScene(path, options));
}

// images: arrays (height, width, 3) of numbers in 0..1.
std::shared_ptr<gs::Scene> SceneOfArrays(const std::vector<py::array_t<float>>& images, const std::vector<Doubles>& Ks,
                                         const std::vector<Doubles>& viewmats, const std::vector<std::string>& names,
                                         const Doubles& points, const Doubles& colors, int test_every) {
  auto scene = std::make_shared<gs::Scene>();
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto pixels = images[i].unchecked<3>();
    const int height = static_cast<int>(pixels.shape(0)), width = static_cast<int>(pixels.shape(1));
    gs::View view = ToView(Ks[i], viewmats[i], width, height);
    view.name = names[i];
    view.image = gs::Image(width, height);
    for (int c = 0; c < 3; ++c) {
      float* to = view.image.plane(c);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) *to++ = pixels(y, x, c);
      }
    }
    scene->views.push_back(std::move(view));
  }
  std::ranges::sort(scene->views, {}, &gs::View::name);
  gs::SplitByCount(test_every, &scene->views);
  if (gs::NumTrainingViews(*scene) == 0) throw Error(kBadArgument, "the scene has no training views");
  gs::WorldPoints world;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    world.positions.push_back({points.at(i, 0), points.at(i, 1), points.at(i, 2)});
    world.colors.push_back({static_cast<float>(colors.at(i, 0)), static_cast<float>(colors.at(i, 1)),
                            static_cast<float>(colors.at(i, 2))});
  }
  gs::PlaceInScene(world, scene.get());
  return scene;
}

py::dict DictOf(const gs::Scene& scene, const gs::View& given) {
  gs::View view;  // without the photograph
  view.name = given.name, view.role = given.role, view.camera = given.camera;
  view.rotation = given.rotation, view.translation = given.translation;
  gs::MoveToWorld(scene, &view);
  py::dict result;
  result["name"] = view.name;
  result["width"] = view.camera.width;
  result["height"] = view.camera.height;
  result["role"] = view.is_test() ? "test" : view.is_trained() ? "train" : "held out";
  const splat::Lens& lens = view.camera.lens;
  Doubles K({3, 3}), viewmat({4, 4});
  const double k[] = {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
  std::copy_n(k, 9, K.mutable_data());
  std::fill_n(viewmat.mutable_data(), 16, 0.0);
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) viewmat.mutable_at(r, c) = view.rotation[3 * r + c];
    viewmat.mutable_at(r, 3) = view.translation[r];
  }
  viewmat.mutable_at(3, 3) = 1;
  result["K"] = K;
  result["viewmat"] = viewmat;
  return result;
}

// The photograph, (height, width, 3): read-only and without a copy. It keeps the scene alive.
py::array_t<float> PhotographOf(const std::shared_ptr<gs::Scene>& scene, std::size_t index) {
  struct Owner {
    std::shared_ptr<gs::Scene> scene;
    std::shared_ptr<const gs::Image> image;
  };
  auto owner = std::make_unique<Owner>(Owner{scene, scene->views.at(index).Photograph()});
  const gs::Image& image = *owner->image;
  const py::capsule holder(owner.release(), [](void* p) { delete static_cast<Owner*>(p); });
  const py::ssize_t value = sizeof(float), row = value * image.width, plane = row * image.height;
  const std::vector<py::ssize_t> shape = {image.height, image.width, 3}, strides = {row, value, plane};
  py::array_t<float> result(shape, strides, image.rgb.data(), holder);
  result.attr("setflags")(py::arg("write") = false);
  return result;
}

py::dict DictOf(const gs::HistoryRow& row) {
  py::dict result;
  result["stage"] = gs::StageName(row.stage);
  result["iteration"] = row.iteration;
  result["seconds"] = row.seconds;
  result["cost"] = row.cost;
  result["gaussians"] = row.gaussians;
  result["train_psnr"] = row.train.psnr;
  result["train_ssim"] = row.train.ssim;
  result["test_psnr"] = row.test.psnr;
  result["test_ssim"] = row.test.ssim;
  return result;
}

// Ctrl-C, or a callback that returns False, stops the training after the present iteration.
class Stopping {
 public:
  explicit Stopping(const py::object& callback) : callback_(callback) {}
  gs::TrainCallbacks Callbacks() {
    gs::TrainCallbacks callbacks;
    callbacks.stop = [this] {
      const py::gil_scoped_acquire gil;
      if (!stopped_ && PyErr_CheckSignals() != 0) stopped_ = true, error_.emplace();
      return stopped_;
    };
    if (!callback_.is_none()) {
      callbacks.evaluated = [this](const gs::HistoryRow& row, const splat::Model<float>&) {
        const py::gil_scoped_acquire gil;
        if (stopped_) return;
        try {
          stopped_ = callback_(DictOf(row)).is(py::bool_(false));
        } catch (py::error_already_set& error) {
          stopped_ = true, error_ = std::move(error);
        }
      };
    }
    return callbacks;
  }
  void Rethrow() const {
    if (error_) throw *error_;
  }

 private:
  const py::object& callback_;
  bool stopped_ = false;
  std::optional<py::error_already_set> error_;
};

// splat: the arrays to refine or prune; None to train from the scene's points. max_loss: as in PruneAtStart.
py::tuple Train(const std::shared_ptr<gs::Scene>& scene, const std::string& kind, const py::object& splat,
                const std::string& preset, const Texts& given, std::optional<double> max_loss,
                const py::object& callback) {
  gs::TrainOptions options = OptionsOf(kind, preset, given);
  gs::SplatModel model;
  if (!splat.is_none()) {
    model = gs::AtStoredDegrees(ToModel(splat.cast<py::dict>()));
    gs::MoveToScene(*scene, &model);
    for (std::size_t c = 0; c < 3; ++c) options.background[c] = static_cast<double>(model.background[c]);
    options.eps2d = model.eps2d, options.antialias = model.antialiased;
  }
  Stopping stopping(callback);
  const gs::TrainCallbacks callbacks = stopping.Callbacks();
  gs::TrainResult result;
  std::string pruned;
  {
    const py::gil_scoped_release release;
    if (kind == "prune") pruned = gs::PruneAtStart(*scene, max_loss, options, model);
    result = splat.is_none() ? gs::Train(*scene, options, {}, callbacks)
                             : gs::Refine(*scene, std::move(model), options, {}, callbacks);
    gs::MoveToWorld(*scene, &result.model);
  }
  stopping.Rethrow();
  py::list history;
  for (const gs::HistoryRow& row : result.history) history.append(DictOf(row));
  std::vector<std::string> notes = result.notes;
  if (!pruned.empty()) notes.push_back(pruned);
  if (!result.lm_left_out.empty()) notes.push_back(result.lm_left_out);
  return py::make_tuple(ToArrays(result.model), history, result.stopped, notes);
}

// Quality of each of these views, in their order.
py::list Evaluate(const std::shared_ptr<gs::Scene>& scene, const py::dict& splat,
                  const std::vector<std::size_t>& views) {
  gs::SplatModel model = ToModel(splat);
  gs::MoveToScene(*scene, &model);
  std::vector<gs::Quality> qualities;
  {
    const py::gil_scoped_release release;
    const std::array<double, 3> background{model.background[0], model.background[1], model.background[2]};
    gs::Renderer renderer(background, gs::NearPlane(*scene));
    for (const std::size_t index : views) {
      gs::Scene one;
      one.extent = scene->extent;
      one.views = {scene->views.at(index)};
      one.views[0].role = gs::ViewRole::kTest;
      one.views[0].camera.eps2d = model.eps2d;
      one.views[0].camera.antialiased = model.antialiased;
      qualities.push_back(renderer.Evaluate(model, one).test);
    }
  }
  py::list result;
  for (std::size_t i = 0; i < views.size(); ++i) {
    py::dict row;
    row["name"] = scene->views[views[i]].name;
    row["psnr"] = qualities[i].psnr;
    row["ssim"] = qualities[i].ssim;
    result.append(row);
  }
  return result;
}

}  // namespace

void AddScene(py::module_& module) {
  py::class_<gs::Scene, std::shared_ptr<gs::Scene>>(module, "Scene")
      .def_property_readonly("views",
                             [](const gs::Scene& scene) {
                               py::list views;
                               for (const gs::View& view : scene.views) views.append(DictOf(scene, view));
                               return views;
                             })
      .def("photograph", &PhotographOf)
      .def_property_readonly("points",
                             [](const gs::Scene& scene) {
                               Doubles points({py::ssize_t{scene.points.size()}, py::ssize_t{3}});
                               double* to = points.mutable_data();
                               for (const std::array<float, 3>& point : scene.points.positions) {
                                 for (std::size_t c = 0; c < 3; ++c) {
                                   *to++ = static_cast<double>(point[c]) + scene.origin[c];
                                 }
                               }
                               return points;
                             })
      .def_readonly("notes", &gs::Scene::notes);
  module.def("load_scene", &LoadScene, py::arg("path"), py::arg("downscale"), py::arg("test_every").none(true),
             py::arg("test_list"), py::arg("hold_out"), py::arg("image_folder"), py::arg("allow_missing"),
             py::arg("photographs_mib").none(true), py::arg("seed"), py::arg("background"), py::arg("eps2d"),
             py::arg("antialiased"));
  module.def("scene_of_arrays", &SceneOfArrays);
  module.def("train", &Train, py::arg("scene"), py::arg("kind"), py::arg("splat").none(true), py::arg("preset"),
             py::arg("options"), py::arg("max_loss").none(true), py::arg("callback").none(true));
  module.def("evaluate", &Evaluate);
}

}  // namespace vesta::python
