// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "kernels/core/files.h"
#include "splatting/io/bytes/byte_reader.h"
#include "splatting/io/scenes/colmap_files.h"

namespace vesta::gs {
namespace {

// Sizes beyond int become negative and are refused by CheckColmapCamera.
int ImageSide(std::uint64_t value) { return value <= std::numeric_limits<int>::max() ? static_cast<int>(value) : -1; }

std::vector<ColmapCamera> ReadCameras(const std::string& folder) {
  ByteReader in(folder + "/cameras.bin");
  std::vector<ColmapCamera> cameras(static_cast<std::size_t>(in.ReadCount(48, "the number of cameras")));
  for (ColmapCamera& record : cameras) {
    record.id = in.Read<std::uint32_t>("a camera's id");
    const std::string where = in.Where();
    const auto model = in.Read<std::int32_t>("a camera's model");
    const CameraModelInfo* info = FindCameraModel(model);
    if (info == nullptr) FailCameraModel(folder, in.Where(), CameraModelName(model));
    record.camera.width = ImageSide(in.Read<std::uint64_t>("a camera's width"));
    record.camera.height = ImageSide(in.Read<std::uint64_t>("a camera's height"));
    ReadParameters(
        *info, [&](const char* what) { return in.Read<double>(what); }, &record);
    CheckColmapCamera(record, where);
  }
  in.ExpectEnd();
  return cameras;
}

std::vector<ColmapImage> ReadImages(const std::string& folder) {
  ByteReader in(folder + "/images.bin");
  std::vector<ColmapImage> images(static_cast<std::size_t>(in.ReadCount(73, "the number of images")));
  for (ColmapImage& image : images) {
    image.id = in.Read<std::uint32_t>("an image's id");
    const std::string where = in.Where();
    for (double& v : image.rotation) v = in.Read<double>("an image's rotation");
    for (double& v : image.translation) v = in.Read<double>("an image's translation");
    image.camera_id = in.Read<std::uint32_t>("an image's camera");
    image.name = in.ReadText("an image's name");
    CheckColmapImage(image, where);
    in.Skip(in.ReadCount(24, "an image's number of 2-D points"), 24, "an image's 2-D points");
  }
  in.ExpectEnd();
  return images;
}

std::vector<ColmapPoint> ReadPoints(const std::string& folder) {
  ByteReader in(folder + "/points3D.bin");
  std::vector<ColmapPoint> points(static_cast<std::size_t>(in.ReadCount(51, "the number of points")));
  for (ColmapPoint& point : points) {
    point.id = in.Read<std::uint64_t>("a point's id");
    for (double& v : point.position) v = in.Read<double>("a point's position");
    CheckColmapPoint(point, in.Where());
    for (std::uint8_t& v : point.color) v = in.Read<std::uint8_t>("a point's colour");
    point.error = in.Read<double>("a point's error");
    in.Skip(in.ReadCount(8, "the length of a point's track"), 8, "a point's track");
  }
  in.ExpectEnd();
  return points;
}

template <class T>
void Append(std::string* bytes, T value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

ColmapModel ReadColmapBinary(const std::string& folder) {
  return {ReadCameras(folder), ReadImages(folder), ReadPoints(folder)};
}

void WriteColmapBinary(const ColmapModel& model, const std::string& folder) {
  std::string bytes;
  Append(&bytes, std::uint64_t{model.cameras.size()});
  for (const ColmapCamera& record : model.cameras) {
    Append(&bytes, record.id);
    Append(&bytes, static_cast<std::int32_t>(record.model));
    Append(&bytes, static_cast<std::uint64_t>(record.camera.width));
    Append(&bytes, static_cast<std::uint64_t>(record.camera.height));
    WriteParameters(record, [&](double value) { Append(&bytes, value); });
  }
  WriteFileAtomically(folder + "/cameras.bin", bytes);

  bytes.clear();
  Append(&bytes, std::uint64_t{model.images.size()});
  for (const ColmapImage& image : model.images) {
    Append(&bytes, image.id);
    for (double v : image.rotation) Append(&bytes, v);
    for (double v : image.translation) Append(&bytes, v);
    Append(&bytes, image.camera_id);
    bytes.append(image.name.c_str(), image.name.size() + 1);
    Append(&bytes, std::uint64_t{0});
  }
  WriteFileAtomically(folder + "/images.bin", bytes);

  bytes.clear();
  Append(&bytes, std::uint64_t{model.points.size()});
  for (const ColmapPoint& point : model.points) {
    Append(&bytes, point.id);
    for (double v : point.position) Append(&bytes, v);
    for (std::uint8_t v : point.color) Append(&bytes, v);
    Append(&bytes, point.error);
    Append(&bytes, std::uint64_t{0});
  }
  WriteFileAtomically(folder + "/points3D.bin", bytes);
}

}  // namespace vesta::gs
