// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/colmap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "kernels/core/check.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/scenes/colmap_files.h"
#include "splatting/io/scenes/find_photograph.h"
#include "splatting/io/scenes/load_scene.h"

namespace vesta::gs {
namespace {

namespace fs = std::filesystem;

template <std::size_t N>
bool AllFinite(const std::array<double, N>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

std::array<double, 4> Normalized(std::array<double, 4> q) {
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  for (double& v : q) v /= norm;
  return q;
}

// Checks that involve several records.
void CheckModel(const ColmapModel& model, const std::string& folder) {
  if (model.cameras.empty()) Fail(kBadFile, "{}: the model has no cameras; run colmap's mapper again", folder);
  if (model.images.empty()) Fail(kBadFile, "{}: the model has no images; run colmap's mapper again", folder);
  std::unordered_set<std::uint32_t> camera_ids;
  for (const ColmapCamera& camera : model.cameras) {
    if (!camera_ids.insert(camera.id).second) {
      Fail(kBadFile, "{}: camera {} occurs twice; export the model again", folder, camera.id);
    }
  }
  std::unordered_set<std::string> names;
  for (const ColmapImage& image : model.images) {
    if (!camera_ids.contains(image.camera_id)) {
      Fail(kBadFile, "{}: image {} refers to camera {}, which the model does not have; export the model again", folder,
           image.name, image.camera_id);
    }
    if (!names.insert(image.name).second) {
      Fail(kBadFile, "{}: image {} occurs twice; export the model again", folder, image.name);
    }
  }
}

bool IsText(const std::string& folder) {
  return !FileExists(folder + "/cameras.bin") && FileExists(folder + "/cameras.txt");
}

std::vector<std::string> ModelFiles(const std::string& folder) {
  std::vector<std::string> files;
  for (const char* name : {"/cameras", "/images", "/points3D"}) {
    files.push_back(folder + name + (IsText(folder) ? ".txt" : ".bin"));
  }
  return files;
}

// " of 12 images", from the count in a binary file; empty if it cannot be read.
std::string OfImages(const std::string& folder) {
  std::ifstream file(folder + "/images.bin", std::ios::binary);
  std::uint64_t count = 0;
  file.read(reinterpret_cast<char*>(&count), sizeof(count));
  constexpr std::uint64_t kMost = 1'000'000'000;
  return file && count <= kMost ? fmt::format(" of {} images", count) : std::string();
}

// If COLMAP's mapper cannot join all images, it writes several models, and the first need not be the largest.
void NoteOtherModels(const std::string& folder, Scene* scene) {
  std::vector<std::string> others;
  std::error_code ignored;
  for (fs::directory_iterator it(fs::path(folder).parent_path(), ignored), end; !ignored && it != end;
       it.increment(ignored)) {
    const std::string other = it->path().string();
    if (it->path().filename() == fs::path(folder).filename()) continue;
    if (FileExists(other + "/images.bin") || FileExists(other + "/images.txt")) others.push_back(other);
  }
  std::sort(others.begin(), others.end());
  for (const std::string& other : others) {
    scene->notes.push_back(fmt::format("the model in {}{} is ignored; the model in {}{} is used", other,
                                       OfImages(other), folder, OfImages(folder)));
  }
}

// A COLMAP camera model with all parameters of the lens.
ColmapCameraModel ModelOf(const LensCamera& bent) {
  if (bent.distortion.is_fisheye) return ColmapCameraModel::kOpenCvFisheye;
  if (!bent.distortion.is_none()) return ColmapCameraModel::kFullOpenCv;
  return bent.camera.lens.fx == bent.camera.lens.fy ? ColmapCameraModel::kSimplePinhole : ColmapCameraModel::kPinhole;
}

// Adds the camera if it is new.
std::uint32_t IdOf(const LensCamera& bent, std::vector<ColmapCamera>* cameras) {
  const auto same = std::ranges::find_if(*cameras, [&](const ColmapCamera& other) {
    return LensCamera{other.camera, other.distortion} == bent;
  });
  if (same != cameras->end()) return same->id;
  const auto id = static_cast<std::uint32_t>(cameras->size() + 1);
  cameras->push_back({.id = id, .model = ModelOf(bent), .camera = bent.camera, .distortion = bent.distortion});
  return id;
}

bool IsFiniteInFloat(const ColmapPoint& point) {
  return std::ranges::all_of(point.position, [](double value) {
    return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
  });
}

}  // namespace

void CheckColmapCamera(const ColmapCamera& record, const std::string& where) {
  const Camera& c = record.camera;
  if (c.width <= 0 || c.height <= 0) {
    Fail(kBadFile, "{}: camera {} has the size {} x {}; calibrate it again", where, record.id, c.width, c.height);
  }
  if (!(c.lens.fx > 0 && c.lens.fy > 0 && std::isfinite(c.lens.fx) && std::isfinite(c.lens.fy))) {
    Fail(kBadFile, "{}: camera {} has the focal lengths {}, {}; they must be positive: calibrate it again", where,
         record.id, c.lens.fx, c.lens.fy);
  }
  if (!std::isfinite(c.lens.cx) || !std::isfinite(c.lens.cy)) {
    Fail(kBadFile, "{}: camera {} has the principal point {}, {}; calibrate it again", where, record.id, c.lens.cx,
         c.lens.cy);
  }
  if (!record.distortion.is_finite()) {
    Fail(kBadFile, "{}: camera {} has a distortion that is not finite; calibrate it again", where, record.id);
  }
}

void CheckColmapImage(const ColmapImage& image, const std::string& where) {
  constexpr std::size_t kLongestName = 4096;  // the system's limit on path lengths
  if (image.name.empty() || image.name.size() > kLongestName ||
      std::any_of(image.name.begin(), image.name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; })) {
    Fail(kBadFile, "{}: image {} has no readable name; the file is damaged, copy or export it again", where, image.id);
  }
  if (!AllFinite(image.rotation) || !AllFinite(image.translation)) {
    Fail(kBadFile, "{}: the pose of image {} is not finite; remove the image from the model", where, image.name);
  }
  const auto& q = image.rotation;
  const double size = std::abs(q[0]) + std::abs(q[1]) + std::abs(q[2]) + std::abs(q[3]);
  if (!(size > 1e-6) || !std::isfinite(size)) {
    Fail(kBadFile, "{}: the rotation of image {} is a quaternion of length zero; remove the image from the model",
         where, image.name);
  }
}

void FailCameraModel(const std::string& folder, const std::string& where, const std::string& model) {
  fs::path scene = fs::path(folder).parent_path();
  if (scene.filename() == "sparse") scene = scene.parent_path();
  Fail(kUnsupported,
       "{}: the camera model {} is not supported; undistort with: colmap image_undistorter --image_path {}/images "
       "--input_path {} --output_path {}_undistorted",
       where, model, scene.string(), folder, scene.string());
}

ColmapModel ReadColmapModel(const std::string& folder, bool tracks) {
  ColmapModel model = IsText(folder) ? ReadColmapText(folder, tracks) : ReadColmapBinary(folder, tracks);
  CheckModel(model, folder);
  model.unusable_points =
      static_cast<Index>(std::erase_if(model.points, [](const ColmapPoint& point) { return !IsFiniteInFloat(point); }));
  return model;
}

void WriteColmapModel(const ColmapModel& model, const std::string& folder, ColmapFormat format) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) Fail(kCannotWrite, "{}: cannot be created: {}", folder, error.message());
  if (format == ColmapFormat::kBinary) {
    WriteColmapBinary(model, folder);
  } else {
    WriteColmapText(model, folder);
  }
}

std::string FindColmapModel(const std::string& scene_folder) {
  for (const char* sub : {"sparse/0", "sparse"}) {
    std::string folder = (fs::path(scene_folder) / sub).string();
    if (FolderExists(folder)) return folder;
  }
  return {};
}

Scene ReadColmapScene(const std::string& scene_folder, const std::string& image_folder, const RandomPoints& random) {
  const std::string folder = FindColmapModel(scene_folder);
  if (folder.empty()) Fail(kNotFound, "{}: no COLMAP model in sparse/0 or sparse", scene_folder);
  const ColmapModel model = ReadColmapModel(folder);
  std::unordered_map<std::uint32_t, const ColmapCamera*> cameras;
  for (const ColmapCamera& record : model.cameras) cameras[record.id] = &record;

  Scene scene;
  scene.files = ModelFiles(folder);
  if (fs::path(folder).parent_path().filename() == "sparse") NoteOtherModels(folder, &scene);
  if (std::ssize(model.images) < model.stated_images) {
    scene.notes.push_back(fmt::format("{}/images.txt has {} images, but its header states {}", folder,
                                      model.images.size(), model.stated_images));
  }
  if (model.unusable_points > 0) {
    if (model.points.empty()) {
      Fail(kBadFile, "{}: all {} points are not finite or too large; repair or remove them", folder,
           model.unusable_points);
    }
    scene.notes.push_back(fmt::format("{}: {} of {} points are not finite or too large and are left out", folder,
                                      model.unusable_points, model.unusable_points + std::ssize(model.points)));
  }
  PhotographFinder finder;
  for (const ColmapImage& image : model.images) {
    View view;
    view.id = image.id;
    view.name = WithSlashes(image.name);
    if (LeavesScene(image_folder, view.name)) {
      Fail(kBadFile, "{}: image {} lies outside the scene; move it into {}/{}", folder, Printable(image.name),
           scene_folder, image_folder);
    }
    view.image_path = finder.Find((fs::path(scene_folder) / image_folder).string(), view.name);
    view.camera = cameras.at(image.camera_id)->camera;
    view.distortion = cameras.at(image.camera_id)->distortion;
    RotationFromQuaternion(Normalized(image.rotation).data(), view.rotation.data());
    view.translation = image.translation;
    scene.views.push_back(std::move(view));
  }
  WorldPoints points;
  for (const ColmapPoint& point : model.points) {
    std::array<float, 3> color;
    for (std::size_t i = 0; i < 3; ++i) color[i] = static_cast<float>(point.color[i]) / 255.0f;
    points.positions.push_back(point.position);
    points.colors.push_back(color);
  }
  SortAndSplit(&scene.views);
  if (points.positions.empty()) points = PointsForCameras("the model in " + folder, random, &scene);
  PlaceInScene(points, &scene);
  return scene;
}

PointTracks ReadTracks(const std::string& scene_folder, const Scene& scene) {
  const std::string folder = FindColmapModel(scene_folder);
  if (folder.empty()) return {};
  ColmapModel model = ReadColmapModel(folder, true);
  if (std::ssize(model.points) != scene.points.size()) return {};
  PointTracks tracks;
  tracks.reserve(model.points.size());
  bool any = false;
  for (ColmapPoint& point : model.points) {
    any = any || !point.seen_by.empty();
    tracks.push_back(std::move(point.seen_by));
  }
  return any ? tracks : PointTracks();
}

ColmapModel ColmapOf(const Scene& scene, const std::vector<View>& views) {
  ColmapModel model;
  for (const View& view : views) {
    ColmapImage image{.id = static_cast<std::uint32_t>(model.images.size() + 1),
                      .translation = view.translation,
                      .camera_id = IdOf(view.bent.value_or(LensCamera{view.camera, {}}), &model.cameras),
                      .name = view.name};
    QuaternionFromRotation(view.rotation.data(), image.rotation.data());
    // From R x + T in the scene's frame to R (x_world - origin) + T.
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) image.translation[i] -= view.rotation[3 * i + j] * scene.origin[j];
    }
    model.images.push_back(image);
  }
  for (std::size_t p = 0; p < scene.points.positions.size(); ++p) {
    ColmapPoint point{.id = p + 1};
    for (std::size_t k = 0; k < 3; ++k) {
      point.position[k] = static_cast<double>(scene.points.positions[p][k]) + scene.origin[k];
      const float color = std::clamp(scene.points.colors[p][k], 0.0f, 1.0f);
      point.color[k] = static_cast<std::uint8_t>(std::lround(255 * color));
    }
    model.points.push_back(point);
  }
  return model;
}

}  // namespace vesta::gs
