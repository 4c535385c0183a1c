// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <concepts>
#include <limits>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "splatting/io/bytes/byte_reader.h"
#include "splatting/io/scenes/colmap_files.h"

namespace vesta::gs {
namespace {

// The words of a text file, line by line. Errors name the file and the line.
class LineReader {
 public:
  explicit LineReader(std::string path) : path_(std::move(path)), text_(ReadFile(path_)), rest_(text_) {}

  // Moves to the next line; false at the end of the file.
  bool NextLine() {
    if (!vesta::NextLine(&rest_, &line_)) return false;
    ++number_;
    return true;
  }
  // Moves to the next line that holds data: neither blank nor a comment.
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
  // A whole number within the range of T.
  template <std::integral T>
  T Whole(const char* what) {
    Index value = 0;
    if (!ParseNumber(Word(what), &value) || value < 0 ||
        static_cast<std::uint64_t>(value) > static_cast<std::uint64_t>(std::numeric_limits<T>::max())) {
      FailWord(what);
    }
    return static_cast<T>(value);
  }
  // What is left of the line, without the white space around it.
  std::string Rest() { return std::string(Trimmed(line_)); }
  std::string Where() const { return fmt::format("{}: line {}", path_, number_); }

 private:
  [[noreturn]] void FailWord(const char* what) const {
    Fail(kBadFile, "{}: {} is not a number that can be used; export the model again", Where(), what);
  }

  std::string path_;
  std::string text_;
  std::string_view rest_, line_;
  Index number_ = 0;
};

std::vector<ColmapCamera> ReadCameras(const std::string& folder) {
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

std::vector<ColmapImage> ReadImages(const std::string& folder) {
  LineReader in(folder + "/images.txt");
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
    in.NextLine();  // The image's 2-D points; blank where it has none.
  }
  return images;
}

std::vector<ColmapPoint> ReadPoints(const std::string& folder) {
  LineReader in(folder + "/points3D.txt");
  std::vector<ColmapPoint> points;
  while (in.NextRecord()) {
    ColmapPoint point;
    point.id = in.Whole<std::uint64_t>("the point's id");
    for (double& v : point.position) v = in.Number("the point's position");
    for (std::uint8_t& v : point.color) v = in.Whole<std::uint8_t>("the point's colour");
    point.error = in.Number("the point's error");
    CheckColmapPoint(point, in.Where());
    points.push_back(point);
  }
  return points;
}

}  // namespace

ColmapModel ReadColmapText(const std::string& folder) {
  return {ReadCameras(folder), ReadImages(folder), ReadPoints(folder)};
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
