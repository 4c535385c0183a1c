// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/write_scene.h"

#include <filesystem>

#include "demo/scene/bent_rays.h"
#include "demo/scene/camera_path.h"
#include "demo/scene/passer_by.h"
#include "demo/scene/random.h"
#include "demo/scene/sfm_points.h"
#include "kernels/core/check.h"
#include "kernels/math/quaternion.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::demo {
namespace {

void CheckRange(const char* name, int value, int low, int high) {
  if (value < low || value > high) Fail(kBadArgument, "--{}={} is out of range; give {} to {}", name, value, low, high);
}

// Unit quaternion (w, x, y, z) of a rotation.
std::array<double, 4> Quaternion(const Frame& f) {
  double R[9];
  for (std::size_t i = 0; i < 3; ++i) R[3 * i] = f.row[i].x, R[3 * i + 1] = f.row[i].y, R[3 * i + 2] = f.row[i].z;
  std::array<double, 4> q{};
  QuaternionFromRotation(R, q.data());
  return q;
}

gs::ColmapImage ModelImage(const View& view, std::uint32_t id, std::string name) {
  const Vec3 t = Rotate(view.cam_from_world, -1.0 * view.position);
  return {.id = id,
          .rotation = Quaternion(view.cam_from_world),
          .translation = {t.x, t.y, t.z},
          .camera_id = 1,
          .name = std::move(name)};
}

// COLMAP's camera model with the fewest parameters for these coefficients.
gs::ColmapCameraModel ModelOf(const gs::Distortion& lens) {
  using enum gs::ColmapCameraModel;
  if (lens.is_none()) return kSimplePinhole;
  if (lens.tangential != std::array{0.0, 0.0}) return kOpenCv;
  return lens.radial[1] == 0 ? kSimpleRadial : kRadial;
}

void CheckLens(const View& view) {
  for (const double u : {0, view.width}) {
    for (const double v : {0, view.height}) {
      const double x = (u - 0.5 * view.width) / view.focal, y = (v - 0.5 * view.height) / view.focal;
      if (!Undistort(view.lens, x, y))
        Fail(kBadArgument, "--lens is not invertible within the image; give coefficients nearer to 0");
    }
  }
}

std::filesystem::path MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    Fail(kCannotWrite, "{}: cannot make this folder ({}); give --out a writable place", folder.string(),
         error.message());
  return folder;
}

}  // namespace

void WriteDemoScene(const DemoOptions& options, const std::string& folder) {
  CheckRange("views", options.views, 2, 9999);
  CheckRange("width", options.width, 8, 4096);
  CheckRange("height", options.height, 8, 4096);
  CheckRange("points", options.points, 1, 1000000);
  CheckRange("passer_by_every", options.passer_by_every, 0, 9999);
  const Scene scene = MakeScene();
  std::vector<View> views =
      (options.round == Round::kWalk ? Walk : CameraPath)(options.views, options.width, options.height);
  for (View& view : views) view.lens = options.lens;
  CheckLens(views[0]);
  const std::filesystem::path image_folder = MakeFolder(std::filesystem::path(folder) / "images");
  const std::filesystem::path mask_folder = std::filesystem::path(folder) / "masks";
  const auto every = static_cast<std::size_t>(options.passer_by_every);
  if (every > 0) MakeFolder(mask_folder);

  const double focal = views[0].focal;
  const gs::Camera camera{.width = options.width,
                          .height = options.height,
                          .lens = {.fx = focal, .fy = focal, .cx = 0.5 * options.width, .cy = 0.5 * options.height}};
  gs::ColmapModel model;
  model.cameras.push_back({.id = 1, .model = ModelOf(options.lens), .camera = camera, .distortion = options.lens});
  std::vector<gs::Image> images;  // without passers-by: for the colours of the points
  for (std::size_t k = 0; k < views.size(); ++k) {
    const std::string name = fmt::format("view_{:04}.png", k);
    images.push_back(Render(scene, views[k], Hash(options.seed, k)));
    gs::Image taken = images.back();
    if (every > 0 && k % every == every / 2) {
      const gs::Image mask = PaintPasserBy(&taken, Hash(Hash(3, options.seed), k));
      gs::SavePng((mask_folder / (name + ".png")).string(), mask);
    }
    gs::SavePng((image_folder / name).string(), taken);
    model.images.push_back(ModelImage(views[k], static_cast<std::uint32_t>(k + 1), name));
  }
  for (const SurfacePoint& p : SampleSurface(scene, views, images, options.points, options.seed)) {
    model.points.push_back({.id = model.points.size() + 1,
                            .position = {p.position.x, p.position.y, p.position.z},
                            .color = {p.color[0], p.color[1], p.color[2]},
                            .error = kPointNoise * camera.lens.fx});
  }
  gs::WriteColmapModel(model, (std::filesystem::path(folder) / "sparse" / "0").string(), gs::ColmapFormat::kBinary);
}

}  // namespace vesta::demo
