// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/nerf.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/find_photograph.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/scenes/nerf_json.h"
#include "splatting/io/scenes/nerf_split.h"
#include "splatting/io/splats/ply.h"

namespace vesta::gs {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// Values of a frame, else from the top level of the file.
class FrameValues {
 public:
  FrameValues(const json& frame, const json& top, std::string where)
      : frame_(frame), top_(top), where_(std::move(where)) {}

  const json* Find(const char* key) const {
    for (const json* source : {&frame_, &top_}) {
      const auto it = source->find(key);
      if (it != source->end() && !it->is_null()) return &*it;
    }
    return nullptr;
  }
  bool Has(const char* key) const { return Find(key) != nullptr; }
  double Number(const char* key, double fallback) const {
    const json* value = Find(key);
    if (value == nullptr) return fallback;
    if (!value->is_number()) Fail(kBadFile, "{}: {} is not a number", where_, key);
    return value->get<double>();
  }
  std::string Text(const char* key, const std::string& fallback) const {
    const json* value = Find(key);
    if (value == nullptr) return fallback;
    if (!value->is_string()) Fail(kBadFile, "{}: {} is not a string", where_, key);
    return value->get<std::string>();
  }
  const std::string& where() const { return where_; }

 private:
  const json& frame_;
  const json& top_;
  std::string where_;
};

bool IsFisheye(const FrameValues& values) {
  const json* flag = values.Find("is_fisheye");
  if (flag != nullptr && !flag->is_boolean())
    Fail(kBadFile, "{}: is_fisheye is neither true nor false", values.where());
  const std::string model = values.Text("camera_model", "PINHOLE");
  if (splat::IndexOf(splat::LensModels(), model) > 0) return false;  // such views are not undistorted
  const std::set<std::string> pinholes = {"PINHOLE",       "SIMPLE_PINHOLE", "PERSPECTIVE", "OPENCV",
                                          "SIMPLE_RADIAL", "RADIAL",         "FULL_OPENCV"},
                              fisheyes = {"OPENCV_FISHEYE", "FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE"};
  if (fisheyes.contains(model)) return true;
  if (!pinholes.contains(model)) {
    Fail(kUnsupported,
         "{}: the camera model {} is not supported; undistort the images first, for instance with colmap "
         "image_undistorter",
         values.where(), Printable(model));
  }
  return flag != nullptr && flag->get<bool>();
}

Distortion ReadDistortion(const FrameValues& values) {
  Distortion lens;
  lens.is_fisheye = IsFisheye(values);
  constexpr const char* kRadial[] = {"k1", "k2", "k3", "k4"};
  constexpr const char* kTangential[] = {"p1", "p2"};
  for (std::size_t i = 0; i < 4; ++i) lens.radial[i] = values.Number(kRadial[i], 0);
  for (std::size_t i = 0; i < 2; ++i) lens.tangential[i] = values.Number(kTangential[i], 0);
  if (lens.is_fisheye && lens.tangential != std::array<double, 2>{}) {
    Fail(kBadFile, "{}: p1 or p2 is not zero, but fisheye lenses have no such parameters; export the cameras again",
         values.where());
  }
  // For nerfstudio, k4 is the coefficient of r^8; for OpenCV, it belongs to a denominator.
  if (!lens.is_fisheye && lens.radial[3] != 0) {
    Fail(kUnsupported,
         "{}: k4 is not zero, but programs define it differently for lenses other than fisheyes; calibrate with k1 to "
         "k3",
         values.where());
  }
  return lens;
}

// Returns false if the file does not state the size.
bool ReadStatedSize(const FrameValues& values, ImageSize* size, const char* width = "w", const char* height = "h") {
  if (!values.Has(width) || !values.Has(height)) return false;
  const double w = values.Number(width, 0), h = values.Number(height, 0);
  if (!(w >= 1 && h >= 1 && w < 1e6 && h < 1e6))
    Fail(kBadFile, "{}: the image size {} x {} is unusable", values.where(), w, h);
  *size = {static_cast<int>(w), static_cast<int>(h)};
  return true;
}

// The size of the camera must be set.
void ReadLens(const FrameValues& values, Camera* camera) {
  const auto focal = [&](const char* length_key, const char* angle_key, int side, double fallback) {
    if (values.Has(length_key) || !values.Has(angle_key)) return values.Number(length_key, fallback);
    return 0.5 * side / std::tan(0.5 * values.Number(angle_key, 0));
  };
  auto& lens = camera->lens;
  if (values.Has("camera_model")) {
    lens.model = std::max(0, splat::IndexOf(splat::LensModels(), values.Text("camera_model", "")));
  }
  lens.fx = focal("fl_x", "camera_angle_x", camera->width, 0);
  lens.fy = focal("fl_y", "camera_angle_y", camera->height, lens.fx);
  lens.cx = values.Number("cx", 0.5 * camera->width);
  lens.cy = values.Number("cy", 0.5 * camera->height);
  if (!(lens.fx > 0 && lens.fy > 0 && std::isfinite(lens.fx) && std::isfinite(lens.fy))) {
    Fail(kBadFile, "{}: the focal lengths {}, {} are unusable; give fl_x or camera_angle_x", values.where(), lens.fx,
         lens.fy);
  }
  if (!std::isfinite(lens.cx) || !std::isfinite(lens.cy)) Fail(kBadFile, "{}: cx or cy is not finite", values.where());
}

// Returns a 0 x 0 camera if the size is not stated and the image may be missing and is.
Camera ReadCamera(const FrameValues& values, const std::string& image_path, bool may_be_missing) {
  Camera camera;
  ImageSize size;
  if (!ReadStatedSize(values, &size)) {
    if (may_be_missing && !FileExists(image_path)) return camera;
    size = ReadImageSize(image_path);
  }
  camera.width = size.width, camera.height = size.height;
  ReadLens(values, &camera);
  return camera;
}

// Files have 6 or 7 digits, so Gram-Schmidt makes the rows orthonormal to double precision. Returns false if the error
// exceeds rounding, or if the matrix is left-handed.
bool Orthonormalize(std::array<double, 9>* rotation) {
  constexpr double kTolerance = 1e-3;
  auto& r = *rotation;
  const auto dot = [&r](std::size_t a, std::size_t b) {
    return r[3 * a] * r[3 * b] + r[3 * a + 1] * r[3 * b + 1] + r[3 * a + 2] * r[3 * b + 2];
  };
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double along = dot(a, b);
      if (!(std::abs(along) < kTolerance)) return false;
      for (std::size_t j = 0; j < 3; ++j) r[3 * a + j] -= along * r[3 * b + j];
    }
    const double norm = std::sqrt(dot(a, a));
    if (!(std::abs(norm - 1) < kTolerance)) return false;
    for (std::size_t j = 0; j < 3; ++j) r[3 * a + j] /= norm;
  }
  const double determinant =
      r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]);
  return determinant > 0;
}

// Converts world_from_camera with OpenGL axes.
void ReadPose(const FrameValues& values, View* view) {
  const json* matrix = values.Find("transform_matrix");
  if (matrix == nullptr) Fail(kBadFile, "{}: the frame has no transform_matrix", values.where());
  double m[3][4];
  const bool has_rows = matrix->is_array() && (matrix->size() == 3 || matrix->size() == 4);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const bool is_number =
          has_rows && (*matrix)[i].is_array() && (*matrix)[i].size() == 4 && (*matrix)[i][j].is_number();
      m[i][j] = is_number ? (*matrix)[i][j].get<double>() : NAN;
      if (!std::isfinite(m[i][j])) Fail(kBadFile, "{}: transform_matrix is not 4 x 4 finite numbers", values.where());
    }
  }
  // The rows of the rotation are the camera's axes in the world: right, down = -up, forward = -backward.
  constexpr double kSign[3] = {1, -1, -1};
  auto& r = view->rotation;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) r[3 * i + j] = kSign[i] * m[j][i];
  }
  if (!Orthonormalize(&r)) {
    Fail(kBadFile, "{}: transform_matrix is not a rotation and a translation; remove scale, shear and mirroring",
         values.where());
  }
  for (std::size_t i = 0; i < 3; ++i) {
    view->translation[i] = -(r[3 * i] * m[0][3] + r[3 * i + 1] * m[1][3] + r[3 * i + 2] * m[2][3]);
  }
}

std::string ImageName(const FrameValues& values) {
  std::string name = values.Text("file_path", "");
  if (name.empty() || std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20; })) {
    Fail(kBadFile, "{}: the frame has no readable file_path", values.where());
  }
  name = NameOfFilePath(WithSlashes(std::move(name)));
  if (LeavesScene("", name)) {
    Fail(kBadFile, "{}: the image {} lies outside the scene; move it there", values.where(), Printable(name));
  }
  return name;
}

// Nerfstudio's mask_path; empty if the frame has none.
std::string MaskPath(const FrameValues& values, const fs::path& folder) {
  const std::string name = WithSlashes(values.Text("mask_path", ""));
  if (LeavesScene("", name)) {
    Fail(kBadFile, "{}: the mask {} lies outside the scene; move it there", values.where(), Printable(name));
  }
  return name.empty() ? name : (folder / name).lexically_normal().string();
}

// The folder that replaces "images" in file names.
struct ImageFolder {
  std::string name;
  bool may_lack_images = false;
  PhotographFinder finder = {};

  std::string PathOf(const fs::path& scene, const View& view, const FrameValues& values) {
    constexpr const char* kUsual = "images";
    const fs::path file(view.name);
    if (name == kUsual) return finder.Find(scene.string(), view.name);
    if (*file.begin() != kUsual) {
      Fail(kBadFile, "{}: --images={}: the image {} is not in images/, which --images replaces", values.where(), name,
           Printable(view.name));
    }
    return finder.Find((scene / name).string(), file.lexically_relative(kUsual).string());
  }
};

constexpr const char* kFrames = "frames";
constexpr const char* kTestFrames = "test_frames";  // ScanNet++: frames of test views, beside kFrames

// Calls take(values) for each frame of top[key].
template <class Take>
void ForEachFrame(const json& top, const char* key, const std::string& path, const Take& take) {
  const auto frames = top.find(key);
  if (!top.is_object() || frames == top.end() || !frames->is_array() || frames->empty()) {
    Fail(kBadFile, "{}: it has no {}", path, key);
  }
  Index number = 0;
  for (const json& frame : *frames) {
    const FrameValues values(frame, top, fmt::format("{}: {} {}", path, key == kFrames ? "frame" : key, number++));
    if (!frame.is_object()) Fail(kBadFile, "{}: not an object", values.where());
    take(values);
  }
}

// ScanNet++ marks blurred frames so.
bool IsBad(const FrameValues& values) {
  const json* flag = values.Find("is_bad");
  if (flag != nullptr && !flag->is_boolean()) Fail(kBadFile, "{}: is_bad is neither true nor false", values.where());
  return flag != nullptr && flag->get<bool>();
}

// Appends the views of the frames top[key] of a transforms file, except frames with is_bad. Adds a note about these.
void ReadFrames(const json& top, const char* key, const std::string& path, ImageFolder& images, Scene* scene) {
  const fs::path folder = fs::path(path).parent_path();
  Index bad = 0;
  ForEachFrame(top, key, path, [&](const FrameValues& values) {
    if (IsBad(values)) {
      ++bad;
      return;
    }
    View view;
    view.name = ImageName(values);
    view.image_path = images.PathOf(folder, view, values);
    view.mask_path = MaskPath(values, folder);
    ReadPose(values, &view);
    // Focal lengths refer to the image in the file, not in images.name.
    view.camera = ReadCamera(values, images.finder.Find(folder.string(), view.name), images.may_lack_images);
    view.distortion = ReadDistortion(values);
    scene->views.push_back(std::move(view));
  });
  if (bad > 0) scene->notes.push_back(fmt::format("{}: {} of the {} have is_bad and are left out", path, bad, key));
}

constexpr const char* kCameraPath = "camera_path";

// The cameras of a camera path of nerfstudio's viewer. A camera has camera_to_world, 16 numbers row by row, and fov,
// the vertical field of view in degrees; render_width and render_height belong to the whole path. `usual` replaces
// missing values.
std::vector<View> ReadCameraPath(const json& top, const std::string& file, Camera usual) {
  std::vector<View> views;
  if (ImageSize size; ReadStatedSize(FrameValues(top, top, file), &size, "render_width", "render_height")) {
    usual = CropCamera(usual, size);
  }
  ForEachFrame(top, kCameraPath, file, [&](const FrameValues& values) {
    View view;
    view.camera = usual;
    const json* numbers = values.Find("camera_to_world");
    if (numbers == nullptr || !numbers->is_array() || numbers->size() != 16) {
      Fail(kBadFile, "{}: camera_to_world is not an array of 16 numbers", values.where());
    }
    json frame = {{"transform_matrix", json::array()}};
    for (std::size_t row = 0; row < 4; ++row) {
      frame["transform_matrix"].push_back(json(numbers->begin() + 4 * static_cast<std::ptrdiff_t>(row),
                                               numbers->begin() + 4 * static_cast<std::ptrdiff_t>(row + 1)));
    }
    ReadPose(FrameValues(frame, top, values.where()), &view);
    const double fov = values.Number("fov", 0);
    if (values.Has("fov") && !(fov > 0 && fov < 180)) Fail(kBadFile, "{}: fov is not within 0..180", values.where());
    if (fov > 0) {
      splat::Lens& lens = view.camera.lens;
      lens.fx = lens.fy = 0.5 * usual.height / std::tan(fov * std::numbers::pi / 360);
      lens.cx = 0.5 * usual.width, lens.cy = 0.5 * usual.height;
    }
    views.push_back(std::move(view));
  });
  return views;
}

// The file with the points, or empty.
std::string FindPoints(const fs::path& folder, const std::string& transforms, const json& top) {
  const std::string named = WithSlashes(FrameValues(top, top, transforms).Text("ply_file_path", ""));
  if (LeavesScene("", named)) {
    Fail(kBadFile, "{}: the points {} lie outside the scene; move them there", transforms, Printable(named));
  }
  if (!named.empty()) return (folder / named).string();
  for (const char* name : {"points3D.ply", "points3d.ply", "sparse_pc.ply"}) {
    std::string path = (folder / name).string();
    if (FileExists(path)) return path;
  }
  return {};
}

}  // namespace

bool IsNerfScene(const std::string& scene_folder) {
  return FileExists(scene_folder + "/transforms.json") || FileExists(scene_folder + "/transforms_train.json");
}

Scene ReadNerfScene(const std::string& scene_folder, const NerfOptions& options) {
  const fs::path folder(scene_folder);
  ImageFolder images{options.image_folder, options.allow_missing};
  const bool has_train_file = FileExists(scene_folder + "/transforms_train.json");
  Scene scene;
  const auto read_file = [&](const char* name) {
    scene.files.push_back((folder / name).string());
    json top = ReadJson(scene.files.back());
    ReadFrames(top, kFrames, scene.files.back(), images, &scene);
    return top;
  };
  const json top = read_file(has_train_file ? "transforms_train.json" : "transforms.json");
  const std::size_t num_train = scene.views.size();
  constexpr const char* kTestFile = "transforms_test.json";
  if (has_train_file && FileExists((folder / kTestFile).string())) {
    read_file(kTestFile);
    scene.split = kTestFile;
  }
  const auto test_frames = top.find(kTestFrames);
  if (test_frames != top.end() && !test_frames->empty()) {
    ReadFrames(top, kTestFrames, scene.files.front(), images, &scene);
    scene.split = kTestFrames;
  }
  std::set<std::string> test_names;
  for (std::size_t i = num_train; i < scene.views.size(); ++i) test_names.insert(scene.views[i].name);
  SortAndSplit(&scene.views);
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    View& view = scene.views[i];
    if (i > 0 && view.name == scene.views[i - 1].name) {
      Fail(kBadFile, "{}: image {} occurs twice in the transforms", scene_folder, view.name);
    }
    if (!test_names.empty()) {
      view.role = test_names.contains(view.name) ? ViewRole::kTest : ViewRole::kTraining;
    }
  }
  if (options.follow_split && test_names.empty()) ApplySplitLists(top, scene.files.front(), &scene);
  const std::string points = FindPoints(folder, scene.files.front(), top);
  if (!points.empty()) scene.files.push_back(points);
  PlaceInScene(points.empty() ? PointsForCameras(scene_folder, options.random_points, &scene)
                              : ReadPointPly(points, &scene.notes),
               &scene);
  return scene;
}

std::vector<View> ReadNerfCameras(const std::string& file, const Camera& usual) {
  std::vector<View> views;
  const json top = ReadJson(file);
  if (top.is_object() && top.contains(kCameraPath)) return ReadCameraPath(top, file, usual);
  ForEachFrame(top, kFrames, file, [&](const FrameValues& values) {
    View view;
    view.camera = usual;
    ImageSize size;
    const bool has_size = ReadStatedSize(values, &size);
    if (has_size) view.camera.width = size.width, view.camera.height = size.height;
    if (has_size || values.Has("fl_x") || values.Has("camera_angle_x")) ReadLens(values, &view.camera);
    ReadPose(values, &view);
    views.push_back(std::move(view));
  });
  return views;
}

void WriteNerfCameras(const std::string& file, const std::vector<View>& views,
                      const std::vector<std::pair<std::string, double>>& more) {
  nlohmann::ordered_json top = nlohmann::ordered_json::object();
  for (const auto& [key, value] : more) top[key] = value;
  auto& frames = top["frames"] = nlohmann::ordered_json::array();
  for (const View& view : views) {
    const splat::Lens& lens = view.camera.lens;
    const auto& r = view.rotation;
    const auto center = CameraCenter(view);
    // The columns are the camera's axes in the world (right, up, backward) and its centre.
    auto matrix = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < 3; ++i) matrix.push_back({r[i], -r[3 + i], -r[6 + i], center[i]});
    matrix.push_back({0, 0, 0, 1});
    frames.push_back({{"file_path", view.name},
                      {"w", view.camera.width},
                      {"h", view.camera.height},
                      {"fl_x", lens.fx},
                      {"fl_y", lens.fy},
                      {"cx", lens.cx},
                      {"cy", lens.cy},
                      {"transform_matrix", matrix}});
  }
  WriteFileAtomically(file, top.dump(1) + "\n");
}

}  // namespace vesta::gs
