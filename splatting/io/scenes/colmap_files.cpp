// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/colmap_files.h"

#include <algorithm>
#include <concepts>
#include <iterator>
#include <limits>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "splatting/io/bytes/bytes.h"

namespace vesta::gs {
namespace {

using enum CameraParameter;

const std::vector<CameraModelInfo>& Models() {
  using M = ColmapCameraModel;
  static const std::vector<CameraModelInfo> models = {
      {M::kSimplePinhole, "SIMPLE_PINHOLE", false, {kFocal, kCx, kCy}},
      {M::kPinhole, "PINHOLE", false, {kFx, kFy, kCx, kCy}},
      {M::kSimpleRadial, "SIMPLE_RADIAL", false, {kFocal, kCx, kCy, kK1}},
      {M::kRadial, "RADIAL", false, {kFocal, kCx, kCy, kK1, kK2}},
      {M::kOpenCv, "OPENCV", false, {kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2}},
      {M::kOpenCvFisheye, "OPENCV_FISHEYE", true, {kFx, kFy, kCx, kCy, kK1, kK2, kK3, kK4}},
      {M::kFullOpenCv, "FULL_OPENCV", false, {kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kK4, kK5, kK6}},
      {M::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", true, {kFocal, kCx, kCy, kK1}},
      {M::kRadialFisheye, "RADIAL_FISHEYE", true, {kFocal, kCx, kCy, kK1, kK2}},
  };
  return models;
}

template <class Is>
const CameraModelInfo* FindWhere(const Is& is) {
  const auto found = std::find_if(Models().begin(), Models().end(), is);
  return found == Models().end() ? nullptr : &*found;
}

// Sizes above the range of int become negative and are rejected by CheckColmapCamera.
int ImageSide(std::uint64_t value) { return value <= std::numeric_limits<int>::max() ? static_cast<int>(value) : -1; }

std::vector<ColmapCamera> ReadBinaryCameras(const std::string& folder) {
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

std::vector<ColmapImage> ReadBinaryImages(const std::string& folder) {
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

std::vector<ColmapPoint> ReadBinaryPoints(const std::string& folder, bool tracks) {
  ByteReader in(folder + "/points3D.bin");
  std::vector<ColmapPoint> points(static_cast<std::size_t>(in.ReadCount(51, "the number of points")));
  for (ColmapPoint& point : points) {
    point.id = in.Read<std::uint64_t>("a point's id");
    for (double& v : point.position) v = in.Read<double>("a point's position");
    for (std::uint8_t& v : point.color) v = in.Read<std::uint8_t>("a point's colour");
    point.error = in.Read<double>("a point's error");
    const Index length = in.ReadCount(8, "the length of a point's track");
    if (!tracks) {
      in.Skip(length, 8, "a point's track");
      continue;
    }
    for (Index k = 0; k < length; ++k) {
      point.seen_by.push_back(in.Read<std::uint32_t>("an image of a point's track"));
      in.Read<std::uint32_t>("a 2-D point of a point's track");
    }
  }
  in.ExpectEnd();
  return points;
}

template <class T>
void Append(std::string* bytes, T value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// The words of a text file, line by line. Errors name the file and the line.
class LineReader {
 public:
  explicit LineReader(std::string path) : path_(std::move(path)), text_(ReadFile(path_)), rest_(text_) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // Windows editors write it
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  }

  // The lines that have not been read.
  std::string_view rest() const { return rest_; }
  // False at the end of the file.
  bool NextLine() {
    if (!vesta::NextLine(&rest_, &line_)) return false;
    ++number_;
    return true;
  }
  // Skips blank lines and comments.
  bool NextRecord() {
    while (NextLine()) {
      std::string_view words = line_;
      const std::string_view first = NextWord(&words);
      if (!first.empty() && first.front() != '#') return true;
    }
    return false;
  }
  std::string_view Word(const char* what) {
    const std::string_view word = NextWord(&line_);
    if (word.empty()) Fail(kBadFile, "{}: the line ends before {}; export the model again", Where(), what);
    return word;
  }
  double Number(const char* what) {
    double value = 0;
    if (!ParseNumber(Word(what), &value)) FailWord(what);
    return value;
  }
  // Non-negative, in the range of T.
  template <std::integral T>
  T Whole(const char* what) {
    Index value = 0;
    if (!ParseNumber(Word(what), &value) || value < 0 ||
        static_cast<std::uint64_t>(value) > static_cast<std::uint64_t>(std::numeric_limits<T>::max())) {
      FailWord(what);
    }
    return static_cast<T>(value);
  }
  bool HasWord() const { return !Trimmed(line_).empty(); }
  // Without surrounding white space.
  std::string Rest() { return std::string(Trimmed(line_)); }
  std::string Where() const { return fmt::format("{}: line {}", path_, number_); }

 private:
  [[noreturn]] void FailWord(const char* what) const {
    Fail(kBadFile, "{}: {} is not a valid number; export the model again", Where(), what);
  }

  std::string path_;
  std::string text_;
  std::string_view rest_, line_;
  Index number_ = 0;
};

std::vector<ColmapCamera> ReadTextCameras(const std::string& folder) {
  LineReader in(folder + "/cameras.txt");
  std::vector<ColmapCamera> cameras;
  while (in.NextRecord()) {
    ColmapCamera record;
    record.id = in.Whole<std::uint32_t>("the camera's id");
    const std::string_view model = in.Word("the camera's model");
    const CameraModelInfo* info = FindCameraModel(model);
    if (info == nullptr) FailCameraModel(folder, in.Where(), Printable(model));
    record.camera.width = in.Whole<int>("the camera's width");
    record.camera.height = in.Whole<int>("the camera's height");
    ReadParameters(
        *info, [&](const char* what) { return in.Number(what); }, &record);
    CheckColmapCamera(record, in.Where());
    cameras.push_back(record);
  }
  return cameras;
}

// Throws Error unless the current line has 2D points (X Y POINT3D_ID each) or is blank.
void CheckObservations(const ColmapImage& image, LineReader* in) {
  const std::string words = in->Rest();
  std::string_view rest = words;
  Index count = 0;
  double value = 0;
  bool valid = true;
  for (std::string_view word = NextWord(&rest); valid && !word.empty(); word = NextWord(&rest), ++count) {
    valid = ParseNumber(word, &value);
  }
  if (valid && count % 3 == 0) return;
  Fail(kBadFile,
       "{}: this is not the line of 2D points of image {}; each image needs two lines, and the second may be blank",
       in->Where(), image.name);
}

// The number of images in the first comments of images.txt, as COLMAP writes it; 0 without such a comment.
Index StatedImages(std::string_view text) {
  std::string_view rest = text, line;
  constexpr std::string_view kBefore = "# Number of images: ";
  while (NextLine(&rest, &line) && line.starts_with('#')) {
    if (!line.starts_with(kBefore)) continue;
    line.remove_prefix(kBefore.size());
    Index count = 0;
    return ParseNumber(line.substr(0, line.find(',')), &count) ? count : 0;
  }
  return 0;
}

// stated: receives StatedImages.
std::vector<ColmapImage> ReadTextImages(const std::string& folder, Index* stated) {
  LineReader in(folder + "/images.txt");
  *stated = StatedImages(in.rest());
  std::vector<ColmapImage> images;
  while (in.NextRecord()) {
    ColmapImage image;
    image.id = in.Whole<std::uint32_t>("the image's id");
    for (double& v : image.rotation) v = in.Number("the image's rotation");
    for (double& v : image.translation) v = in.Number("the image's translation");
    image.camera_id = in.Whole<std::uint32_t>("the image's camera");
    image.name = in.Rest();
    CheckColmapImage(image, in.Where());
    images.push_back(std::move(image));
    if (in.NextLine()) CheckObservations(images.back(), &in);
  }
  return images;
}

std::vector<ColmapPoint> ReadTextPoints(const std::string& folder, bool tracks) {
  LineReader in(folder + "/points3D.txt");
  std::vector<ColmapPoint> points;
  while (in.NextRecord()) {
    ColmapPoint point;
    point.id = in.Whole<std::uint64_t>("the point's id");
    for (double& v : point.position) v = in.Number("the point's position");
    for (std::uint8_t& v : point.color) v = in.Whole<std::uint8_t>("the point's colour");
    point.error = in.Number("the point's error");
    while (tracks && in.HasWord()) {
      point.seen_by.push_back(in.Whole<std::uint32_t>("an image of the point's track"));
      in.Whole<std::uint32_t>("a 2D point of the point's track");
    }
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace

const CameraModelInfo* FindCameraModel(std::int32_t number) {
  return FindWhere([&](const CameraModelInfo& info) { return static_cast<std::int32_t>(info.model) == number; });
}

const CameraModelInfo* FindCameraModel(std::string_view name) {
  return FindWhere([&](const CameraModelInfo& info) { return info.name == name; });
}

const CameraModelInfo& InfoOf(ColmapCameraModel model) {
  const CameraModelInfo* info = FindCameraModel(static_cast<std::int32_t>(model));
  VESTA_CHECK(info != nullptr, "no camera model has the number {}", static_cast<std::int32_t>(model));
  return *info;
}

std::string CameraModelName(std::int32_t number) {
  constexpr std::int32_t kFov = 7, kThinPrism = 10;
  if (number == kFov) return "FOV";
  if (number == kThinPrism) return "THIN_PRISM_FISHEYE";
  const CameraModelInfo* info = FindCameraModel(number);
  return info ? info->name : std::to_string(number);
}

double& ParameterOf(ColmapCamera& record, CameraParameter parameter) {
  splat::Lens& lens = record.camera.lens;
  switch (parameter) {
    case kFocal:
    case kFx:
      return lens.fx;
    case kFy:
      return lens.fy;
    case kCx:
      return lens.cx;
    case kCy:
      return lens.cy;
    case kP1:
      return record.distortion.tangential[0];
    case kP2:
      return record.distortion.tangential[1];
    default:
      return record.distortion.radial.at(static_cast<std::size_t>(parameter) - static_cast<std::size_t>(kK1));
  }
}

const char* WhatIs(CameraParameter parameter) {
  switch (parameter) {
    case kFocal:
    case kFx:
    case kFy:
      return "the camera's focal length";
    case kCx:
    case kCy:
      return "the camera's principal point";
    default:
      return "the camera's distortion";
  }
}

ColmapModel ReadColmapBinary(const std::string& folder, bool tracks) {
  return {ReadBinaryCameras(folder), ReadBinaryImages(folder), ReadBinaryPoints(folder, tracks), 0};
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

ColmapModel ReadColmapText(const std::string& folder, bool tracks) {
  ColmapModel model;
  model.cameras = ReadTextCameras(folder);
  model.images = ReadTextImages(folder, &model.stated_images);
  model.points = ReadTextPoints(folder, tracks);
  return model;
}

void WriteColmapText(const ColmapModel& model, const std::string& folder) {
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (const ColmapCamera& record : model.cameras) {
    text += fmt::format("{} {} {} {}", record.id, InfoOf(record.model).name, record.camera.width, record.camera.height);
    WriteParameters(record, [&](double value) { text += fmt::format(" {}", value); });
    text += "\n";
  }
  WriteFileAtomically(folder + "/cameras.txt", text);

  text = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of 2-D points: X Y POINT3D_ID ...\n";
  for (const ColmapImage& image : model.images) {
    const auto& q = image.rotation;
    const auto& t = image.translation;
    text += fmt::format("{} {} {} {} {} {} {} {} {} {}\n\n", image.id, q[0], q[1], q[2], q[3], t[0], t[1], t[2],
                        image.camera_id, image.name);
  }
  WriteFileAtomically(folder + "/images.txt", text);

  text = "# POINT3D_ID X Y Z R G B ERROR TRACK[]: IMAGE_ID POINT2D_IDX ...\n";
  for (const ColmapPoint& point : model.points) {
    const auto& p = point.position;
    text += fmt::format("{} {} {} {} {} {} {} {}\n", point.id, p[0], p[1], p[2], point.color[0], point.color[1],
                        point.color[2], point.error);
  }
  WriteFileAtomically(folder + "/points3D.txt", text);
}

}  // namespace vesta::gs
