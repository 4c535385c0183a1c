// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/glb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {
namespace {

using nlohmann::json;

constexpr const char* kExtension = "KHR_gaussian_splatting";
constexpr int kByte = 5121, kFloat = 5126, kArrayBuffer = 34962, kPoints = 0;  // numbers of OpenGL
constexpr int kVertical = 2;                                                   // HalfTurnSign

// The values of a Gaussian in one attribute of the file.
using Row = std::array<float, 4>;

struct GlbAttribute {
  std::string name;
  const char* type;  // in glTF
  Index numbers;     // per Gaussian
  bool is_bytes;
  Row (*row)(const SplatModel& model, Index gaussian, int first);
  int first;  // parameter of row
};

double Opacity(const SplatModel& model, Index i) {
  return 1 / (1 + std::exp(-static_cast<double>(model.attribute(splat::kOpacity)[i])));
}

// Three attributes of the model, in the axes of glTF.
Row Turned(const SplatModel& model, Index i, int first) {
  Row row{};
  for (int k = 0; k < 3; ++k) {
    row[static_cast<std::size_t>(k)] = HalfTurnSign(first + k, kVertical) * model.Value(first + k, i);
  }
  return row;
}

Row Rotation(const SplatModel& model, Index i, int) {
  std::array<double, 4> q{};
  double norm2 = 0;
  for (int k = 0; k < 4; ++k) {
    const int attribute = splat::kQuaternion + (k + 1) % 4;
    const double value = static_cast<double>(HalfTurnSign(attribute, kVertical) * model.attribute(attribute)[i]);
    q[static_cast<std::size_t>(k)] = value;
    norm2 += value * value;
  }
  Row row{};
  std::transform(q.begin(), q.end(), row.begin(),
                 [&](double value) { return static_cast<float>(value / std::sqrt(norm2)); });
  return row;
}

Row Scale(const SplatModel& model, Index i, int) {
  Row row{};
  for (int k = 0; k < 3; ++k) {
    const float scale = std::exp(model.attribute(splat::kLogScale + k)[i]);
    row[static_cast<std::size_t>(k)] = std::min(scale, std::numeric_limits<float>::max());
  }
  return row;
}

Row OpacityRow(const SplatModel& model, Index i, int) { return {static_cast<float>(Opacity(model, i))}; }

// In 0..1.
Row Color(const SplatModel& model, Index i, int) {
  Row row{};
  for (int k = 0; k < 3; ++k) {
    row[static_cast<std::size_t>(k)] = 0.5f + static_cast<float>(sh::k0) * model.attribute(splat::kSh + k)[i];
  }
  row[3] = static_cast<float>(Opacity(model, i));
  return row;
}

// In the order of the file.
std::vector<GlbAttribute> AttributesOf(int sh_degree) {
  const auto extended = [](const std::string& name) { return fmt::format("{}:{}", kExtension, name); };
  std::vector<GlbAttribute> attributes = {{"POSITION", "VEC3", 3, false, Turned, splat::kMean},
                                          {"COLOR_0", "VEC4", 4, true, Color, 0},
                                          {extended("ROTATION"), "VEC4", 4, false, Rotation, 0},
                                          {extended("SCALE"), "VEC3", 3, false, Scale, 0},
                                          {extended("OPACITY"), "SCALAR", 1, false, OpacityRow, 0}};
  for (int degree = 0; degree <= sh_degree; ++degree) {
    for (int k = ShCoefficients(degree - 1); k < ShCoefficients(degree); ++k) {
      attributes.push_back({extended(fmt::format("SH_DEGREE_{}_COEF_{}", degree, k - ShCoefficients(degree - 1))),
                            "VEC3", 3, false, Turned, splat::kSh + 3 * k});
    }
  }
  return attributes;
}

Index BytesPerGaussian(const GlbAttribute& attribute) { return attribute.numbers * (attribute.is_bytes ? 1 : 4); }

// The description of the file, without spaces at its end.
std::string Describe(const SplatModel& model, const std::vector<GlbAttribute>& attributes) {
  json views = json::array(), accessors = json::array(), names;
  Index offset = 0;
  for (const GlbAttribute& attribute : attributes) {
    const Index bytes = model.count * BytesPerGaussian(attribute);
    names[attribute.name] = views.size();
    accessors.push_back({{"bufferView", views.size()},
                         {"componentType", attribute.is_bytes ? kByte : kFloat},
                         {"normalized", attribute.is_bytes},
                         {"count", model.count},
                         {"type", attribute.type}});
    views.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", kArrayBuffer}});
    offset += bytes;
  }
  for (int k = 0; k < 3; ++k) {
    const float* mean = model.attribute(splat::kMean + k);
    const auto [least, greatest] = std::minmax_element(mean, mean + model.count);
    const float sign = HalfTurnSign(splat::kMean + k, kVertical);
    accessors[0]["min"].push_back(std::min(sign * *least, sign * *greatest));
    accessors[0]["max"].push_back(std::max(sign * *least, sign * *greatest));
  }
  json asset = {{"version", "2.0"}, {"generator", "vesta"}};
  const std::vector<std::string> comments = PlyComments(model);
  if (!comments.empty()) asset["extras"] = {{"vesta", comments}};
  const json extension = {{"kernel", "ellipse"},
                          {"colorSpace", "srgb_rec709_display"},
                          {"projection", "perspective"},
                          {"sortingMethod", "cameraDistance"}};
  const json primitive = {{"attributes", names}, {"mode", kPoints}, {"extensions", {{kExtension, extension}}}};
  json file = {{"asset", asset}, {"scene", 0}, {"bufferViews", views}, {"accessors", accessors}};
  file["extensionsUsed"] = json::array({kExtension});
  file["scenes"] = json::array({json{{"nodes", json::array({0})}}});
  file["nodes"] = json::array({json{{"mesh", 0}}});
  file["meshes"] = json::array({json{{"primitives", json::array({primitive})}}});
  file["buffers"] = json::array({json{{"byteLength", offset}}});
  return file.dump();
}

void WriteNumbers(AtomicFile* file, const std::vector<std::uint32_t>& numbers) {
  file->Write({reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(std::uint32_t)});
}

void WriteAttribute(AtomicFile* file, const SplatModel& model, const GlbAttribute& attribute) {
  constexpr Index kRowsAtOnce = 4096;
  std::vector<float> floats;
  std::string bytes;
  for (Index begin = 0; begin < model.count; begin += kRowsAtOnce) {
    floats.clear();
    for (Index i = begin; i < std::min(begin + kRowsAtOnce, model.count); ++i) {
      const Row row = attribute.row(model, i, attribute.first);
      floats.insert(floats.end(), row.begin(), row.begin() + attribute.numbers);
    }
    if (attribute.is_bytes) {
      bytes.resize(floats.size());
      std::transform(floats.begin(), floats.end(), bytes.begin(),
                     [](float value) { return static_cast<char>(QuantizeColor(value)); });
      file->Write(bytes);
    } else {
      file->Write({reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float)});
    }
  }
}

}  // namespace

void WriteGlb(const std::string& path, const SplatModel& model) {
  CheckDrawable(path, model);
  if (model.count == 0) Fail(kBadArgument, "{}: cannot write a splat without Gaussians", path);
  const std::vector<GlbAttribute> attributes = AttributesOf(model.sh_degree);
  Index bytes = 0;
  for (const GlbAttribute& attribute : attributes) bytes += model.count * BytesPerGaussian(attribute);
  std::string description = Describe(model, attributes);
  description.resize((description.size() + 3) / 4 * 4, ' ');
  const Index total = bytes + static_cast<Index>(description.size()) + 28;  // with the headers of 12, 8 and 8 bytes
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    Fail(kBadArgument, "{}: {} Gaussians need more than the 4 GiB of a .glb; crop the splat, or write a .sog", path,
         model.count);
  }
  constexpr std::uint32_t kGlbMagic = 0x46546c67, kGlbVersion = 2, kJson = 0x4e4f534a, kBinary = 0x004e4942;
  AtomicFile file(path);
  WriteNumbers(&file, {kGlbMagic, kGlbVersion, static_cast<std::uint32_t>(total),
                       static_cast<std::uint32_t>(description.size()), kJson});
  file.Write(description);
  WriteNumbers(&file, {static_cast<std::uint32_t>(bytes), kBinary});
  for (const GlbAttribute& attribute : attributes) WriteAttribute(&file, model, attribute);
  file.Commit();
}

}  // namespace vesta::gs
