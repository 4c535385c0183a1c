// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <type_traits>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/ply_file.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {
namespace {

// A property of the file and its attribute; -1: normals, which are zero.
struct FileColumn {
  std::string property;
  int attribute;
};

// Columns in the order of the file.
std::vector<FileColumn> FileColumns(int sh_degree) {
  std::vector<FileColumn> columns;
  const auto add = [&columns](const char* prefix, int count, int attribute) {
    for (int i = 0; i < count; ++i) columns.push_back({fmt::format("{}_{}", prefix, i), attribute + i});
  };
  for (int i = 0; i < 3; ++i) columns.push_back({std::string(1, "xyz"[i]), splat::kMean + i});
  for (const char* normal : {"nx", "ny", "nz"}) columns.push_back({normal, -1});
  add("f_dc", 3, splat::kSh);
  const int higher = splat::NumHigherHarmonics(sh_degree), rest = higher / 3;  // per channel
  for (int i = 0; i < higher; ++i) {
    const int channel = i / rest, coefficient = 1 + i % rest;
    columns.push_back({fmt::format("f_rest_{}", i), splat::kSh + 3 * coefficient + channel});
  }
  columns.push_back({"opacity", splat::kOpacity});
  add("scale", 3, splat::kLogScale);
  add("rot", 4, splat::kQuaternion);
  return columns;
}

int DegreeOf(const std::string& path, int num_rest) {
  for (int degree = 0; degree <= 3; ++degree) {
    if (num_rest == splat::NumHigherHarmonics(degree)) return degree;
  }
  Fail(kBadFile, "{}: {} properties f_rest_*; a splat of degree 0, 1, 2 or 3 has 0, 9, 24 or 45", path, num_rest);
}

using ColorNames = std::array<const char*, 3>;

// The names of the colours that the vertices have; null if they have none.
const ColorNames* FindColors(const PlyTable& vertices) {
  static constexpr ColorNames kNames[] = {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}};
  const auto found = std::ranges::find_if(kNames, [&](const ColorNames& names) {
    return std::ranges::all_of(names, [&](const char* name) { return vertices.Has(name); });
  });
  return found == std::end(kNames) ? nullptr : &*found;
}

constexpr const char* kThirdScale = "scale_2";

// Replaces colours in 0..full by the SH coefficients of degree 0.
void ColorsToSh(const PlyTable& vertices, const ColorNames& names, SplatModel* model) {
  for (int k = 0; k < 3; ++k) {
    const float full = vertices.FullScale(names[static_cast<std::size_t>(k)]);
    float* values = model->attribute(splat::kSh + k);
    for (Index i = 0; i < model->count; ++i) {
      values[i] = (values[i] / full - 0.5f) / static_cast<float>(sh::k0);
    }
  }
}

void FlattenThirdScale(SplatModel* model) {
  const float thousandth = std::log(1e-3f);
  for (Index i = 0; i < model->count; ++i) {
    const auto log_scale = [&](int axis) -> float& { return model->attribute(splat::kLogScale + axis)[i]; };
    log_scale(2) = std::min(log_scale(0), log_scale(1)) + thousandth;
  }
}

}  // namespace

SplatModel ReadSplatPly(const std::string& path, std::vector<std::string>* notes) {
  return ReadSplatPly(PlyFile(path), notes);
}

SplatModel ReadSplatPly(const PlyFile& file, std::vector<std::string>* notes) {
  const std::string& path = file.path();
  const PlyTable vertices(file, "vertex");
  SplatModel model;
  model.Resize(DegreeOf(path, vertices.CountWithPrefix("f_rest_")), 0);
  std::vector<FileColumn> columns = FileColumns(model.sh_degree);
  std::erase_if(columns, [](const FileColumn& column) { return column.attribute < 0; });
  const ColorNames* colors = vertices.Has("f_dc_0") ? nullptr : FindColors(vertices);
  const bool is_flat = !vertices.Has(kThirdScale);
  if (is_flat) std::erase_if(columns, [](const FileColumn& column) { return column.property == kThirdScale; });
  for (FileColumn& column : columns) {
    const int channel = column.attribute - splat::kSh;
    if (colors && channel >= 0 && channel < 3) column.property = (*colors)[static_cast<std::size_t>(channel)];
  }
  for (const FileColumn& column : columns) {
    if (!vertices.Has(column.property)) {
      Fail(kBadFile, "{}: not a splat in the INRIA layout: its vertices have no property {}", path, column.property);
    }
  }
  if (vertices.count() == 0) Fail(kBadFile, "{}: it holds no Gaussians", path);
  model.Resize(model.sh_degree, vertices.count());
  ReadSplatComments(path, file.comments(), &model);
  std::vector<PlyTable::Column<float>> copies;
  copies.reserve(columns.size());
  for (const FileColumn& column : columns) copies.push_back({column.property, model.attribute(column.attribute)});
  vertices.Copy(copies);
  if (colors) ColorsToSh(vertices, *colors, &model);
  if (is_flat) FlattenThirdScale(&model);
  // Programs that unpack compact files write opacities of 0 and 1 as infinite logits (packed_values.h).
  for (Index i = 0; i < model.count; ++i) {
    float& logit = model.attribute(splat::kOpacity)[i];
    if (std::isinf(logit)) logit = OpacityLogit(logit > 0 ? 255 : 0);
  }
  RemoveUnusableGaussians(path, notes, &model);
  return AtStoredDegrees(std::move(model));
}

std::int64_t SplatPlyBytes(Index gaussians, int sh_degree) {
  return gaussians * static_cast<std::int64_t>(FileColumns(sh_degree).size() * sizeof(float));
}

void WriteSplatPly(const std::string& path, const SplatModel& model) {
  AtomicFile file(path);
  WriteSplatPly(file, model);
  file.Commit();
}

void WriteSplatPly(AtomicFile& file, const SplatModel& model) {
  VESTA_CHECK(model.sh_degree >= 0 && model.sh_degree <= 3, "degree {}", model.sh_degree);
  VESTA_CHECK(static_cast<Index>(model.data.size()) == model.Size(), "{} values for {} Gaussians of degree {}",
              model.data.size(), model.count, model.sh_degree);
  const std::vector<FileColumn> columns = FileColumns(model.sh_degree);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : PlyComments(model)) header += fmt::format("comment {}\n", comment);
  header += fmt::format("element vertex {}\n", model.count);
  for (const FileColumn& column : columns) header += fmt::format("property float {}\n", column.property);
  header += "end_header\n";

  file.Write(header);
  constexpr Index kRowsAtOnce = 4096;
  std::vector<float> rows;
  for (Index begin = 0; begin < model.count; begin += kRowsAtOnce) {
    const Index end = std::min(begin + kRowsAtOnce, model.count);
    rows.clear();
    for (Index i = begin; i < end; ++i) {
      for (const FileColumn& column : columns) {
        rows.push_back(column.attribute < 0 ? 0.0f : model.Value(column.attribute, i));
      }
    }
    file.Write({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(float)});
  }
}

WorldPoints ReadPointPly(const std::string& path, std::vector<std::string>* notes) {
  const PlyFile file(path);
  const PlyTable vertices(file, "vertex");
  if (vertices.count() == 0) Fail(kBadFile, "{}: it holds no points", path);
  const auto n = static_cast<std::size_t>(vertices.count());
  const ColorNames axes = {"x", "y", "z"};
  const ColorNames* channels = FindColors(vertices);
  std::vector<double> positions(3 * n);
  std::vector<float> colors(3 * n, 0.5f);
  const auto columns = [n](const ColorNames& names, auto* values) {
    std::vector<PlyTable::Column<std::remove_pointer_t<decltype(values)>>> result;
    for (std::size_t k = 0; k < 3; ++k) result.push_back({names[k], values + k * n});
    return result;
  };
  vertices.Copy(columns(axes, positions.data()));
  if (channels) vertices.Copy(columns(*channels, colors.data()));

  WorldPoints cloud;
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, 3> position;
    std::array<float, 3> color;
    bool is_finite = true;
    for (std::size_t k = 0; k < 3; ++k) {
      position[k] = positions[k * n + i];
      color[k] = colors[k * n + i] / (channels ? vertices.FullScale((*channels)[k]) : 1.0f);
      is_finite = is_finite && std::isfinite(static_cast<float>(position[k])) && std::isfinite(color[k]);
      color[k] = std::clamp(color[k], 0.0f, 1.0f);
    }
    if (!is_finite) continue;
    cloud.positions.push_back(position);
    cloud.colors.push_back(color);
  }
  const std::size_t bad = n - cloud.positions.size();
  if (bad == n) Fail(kBadFile, "{}: none of its {} points is finite", path, n);
  if (bad > 0 && notes != nullptr) {
    notes->push_back(fmt::format("{}: {} of {} points are not finite, and are left out", path, bad, n));
  }
  return cloud;
}

}  // namespace vesta::gs
