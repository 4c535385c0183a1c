// A COLMAP scene of pinholes as a distorting lens would have seen it, and beside it the same part of it undistorted.
//
//   distort_scene SCENE DIR [--model OPENCV] [--coefficients -0.1,0.02,0.001,-0.001]
//
// DIR/distorted has a camera of that model of COLMAP's, with these coefficients in its order. DIR/pinhole has the
// pixels of SCENE that loading DIR/distorted keeps, as they are. What a training of the one reaches below the other is
// lost by distorting and undistorting. Images are PNGs, whatever they are called.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/distort_scene/distort.h"
#include "bench/report.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/io/colmap.h"
#include "problems/gaussian_splatting/io/colmap_camera_models.h"
#include "problems/gaussian_splatting/io/image.h"
#include "problems/gaussian_splatting/model/undistort.h"

namespace vesta::bench {
namespace {

namespace fs = std::filesystem;

// A camera of the model with these coefficients after the focal lengths and the principal point of the pinhole.
gs::ColmapCamera CameraOf(const std::string& model, const gs::ColmapCamera& pinhole, const std::string& coefficients) {
  const gs::CameraModelInfo* info = gs::FindCameraModel(model);
  if (!info) Fail("--model={}: not one of COLMAP's that are read", model);
  gs::ColmapCamera camera{.id = pinhole.id, .model = info->model, .camera = pinhole.camera, .distortion = {}};
  camera.distortion.is_fisheye = info->is_fisheye;
  const std::vector<std::string> values = SplitAtCommas(coefficients);
  std::size_t next = 0;
  for (const gs::CameraParameter parameter : info->parameters) {
    if (parameter < gs::CameraParameter::kK1) continue;
    if (next == values.size()) Fail("--coefficients={}: too few for {}", coefficients, model);
    gs::ParameterOf(camera, parameter) = std::stod(values[next++]);
  }
  if (next != values.size()) Fail("--coefficients={}: too many for {}", coefficients, model);
  return camera;
}

// The part of an image of the pinhole `whole`, at whole pixels, that `part` sees: another with the same focal lengths.
gs::Image Crop(const gs::Image& image, const gs::Camera& whole, gs::Camera* part) {
  const int left = static_cast<int>(std::lround(whole.lens.cx - part->lens.cx));
  const int top = static_cast<int>(std::lround(whole.lens.cy - part->lens.cy));
  part->width = std::min(part->width, image.width - left);
  part->height = std::min(part->height, image.height - top);
  part->lens.cx = whole.lens.cx - left;
  part->lens.cy = whole.lens.cy - top;
  gs::Image result(part->width, part->height);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < part->height; ++y) {
      const float* from = image.plane(c) + static_cast<std::ptrdiff_t>(top + y) * image.width + left;
      std::copy(from, from + part->width, result.plane(c) + static_cast<std::ptrdiff_t>(y) * part->width);
    }
  }
  return result;
}

void Save(const gs::Image& image, const std::string& folder, const std::string& name) {
  const fs::path path = fs::path(folder) / "images" / name;
  fs::create_directories(path.parent_path());
  gs::SavePng(path.string(), image);
}

int Main(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"model", "coefficients"});
  if (arguments.positional.size() != 2) throw Error("the form is `distort_scene SCENE DIR`");
  const std::string scene = arguments.positional[0];
  const std::string distorted = arguments.positional[1] + "/distorted", pinhole = arguments.positional[1] + "/pinhole";
  gs::ColmapModel model = gs::ReadColmapModel(gs::FindColmapModel(scene));
  gs::ColmapModel as_distorted = model, as_pinhole = model;
  for (std::size_t k = 0; k < model.cameras.size(); ++k) {
    gs::ColmapCamera& whole = model.cameras[k];
    if (!whole.distortion.is_none()) Fail("{}: its cameras are distorted already", scene);
    for (const gs::ColmapImage& image : model.images) {
      if (image.camera_id != whole.id) continue;
      const gs::Image pixels = gs::LoadImage((fs::path(scene) / "images" / image.name).string());
      whole.camera = gs::ResizeCamera(whole.camera, pixels.width, pixels.height);
      gs::ColmapCamera bent =
          CameraOf(arguments.Flag("model", "OPENCV"), whole, arguments.Flag("coefficients", "-0.1,0.02,0.001,-0.001"));
      bent.camera = DistortedCamera(whole.camera, bent.distortion);
      const std::optional<gs::Camera> kept = gs::PinholeOf(bent.camera, bent.distortion);
      if (!kept) throw Error("hardly anything is left when this lens is undistorted; take smaller coefficients");
      as_distorted.cameras[k] = bent;
      as_pinhole.cameras[k] = {whole.id, gs::ColmapCameraModel::kPinhole, *kept, {}};
      Save(DistortImage(pixels, whole.camera, bent.camera, bent.distortion), distorted, image.name);
      Save(Crop(pixels, whole.camera, &as_pinhole.cameras[k].camera), pinhole, image.name);
    }
  }
  gs::WriteColmapModel(as_distorted, distorted + "/sparse/0", gs::ColmapFormat::kBinary);
  gs::WriteColmapModel(as_pinhole, pinhole + "/sparse/0", gs::ColmapFormat::kBinary);
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("distort_scene", vesta::bench::Main, argc, argv); }
