#include "problems/gaussian_splatting/io/ply.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/io/byte_reader.h"
#include "problems/gaussian_splatting/io/ply_vertices.h"

namespace vesta::gs {
namespace {

constexpr std::string_view kBackgroundComment = "vesta background", kOriginComment = "vesta origin";

// A property of the file and the attribute it holds; -1 for the normals, which are zero.
struct FileColumn {
  std::string property;
  int attribute;
};

// All columns in the order of the file.
std::vector<FileColumn> FileColumns(int sh_degree) {
  std::vector<FileColumn> columns;
  const auto add = [&columns](const char* prefix, int count, int attribute) {
    for (int i = 0; i < count; ++i) columns.push_back({fmt::format("{}_{}", prefix, i), attribute + i});
  };
  for (int i = 0; i < 3; ++i) columns.push_back({std::string(1, "xyz"[i]), splat::kMean + i});
  for (const char* normal : {"nx", "ny", "nz"}) columns.push_back({normal, -1});
  add("f_dc", 3, splat::kSh);
  const int rest = (sh_degree + 1) * (sh_degree + 1) - 1;
  for (int i = 0; i < 3 * rest; ++i) {
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
    if (num_rest == 3 * ((degree + 1) * (degree + 1) - 1)) return degree;
  }
  Fail("{}: {} properties f_rest_*; a splat of degree 0, 1, 2 or 3 has 0, 9, 24 or 45", path, num_rest);
}

// The three numbers after a comment of that beginning, where there is one; each must be one that is_valid.
template <class T>
bool ReadComment(const std::string& path, const std::vector<std::string>& comments, std::string_view beginning,
                 const char* what, bool (*is_valid)(double), std::array<T, 3>* numbers) {
  bool is_there = false;
  for (std::string_view comment : comments) {
    if (!comment.starts_with(beginning)) continue;
    comment.remove_prefix(beginning.size());
    for (T& number : *numbers) {
      double value = 0;
      if (!ParseNumber(NextWord(&comment), &value) || !is_valid(value)) {
        Fail("{}: the comment '{}' is not followed by three {}; correct or remove it", path, beginning, what);
      }
      number = static_cast<T>(value);
    }
    is_there = true;
  }
  return is_there;
}

void ReadComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model) {
  const auto is_color = [](double value) { return value >= 0 && value <= 1; };
  const auto is_place = [](double value) {
    return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
  };
  model->has_background =
      ReadComment(path, comments, kBackgroundComment, "numbers in 0..1", +is_color, &model->background);
  ReadComment(path, comments, kOriginComment, "finite numbers", +is_place, &model->origin);
}

// The Gaussians that can be drawn, in order.
std::vector<Index> UsableGaussians(const SplatModel& model) {
  std::vector<char> usable(static_cast<std::size_t>(model.count));
  ParallelForChunks(model.count, 4096, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const float* q = model.attribute(splat::kQuaternion) + i;
      usable[static_cast<std::size_t>(i)] =
          q[0] != 0 || q[model.count] != 0 || q[2 * model.count] != 0 || q[3 * model.count] != 0;
    }
    for (int a = 0; a < model.num_attributes(); ++a) {
      const float* values = model.attribute(a);
      for (Index i = begin; i < end; ++i) {
        if (!std::isfinite(values[i])) usable[static_cast<std::size_t>(i)] = false;
      }
    }
  });
  std::vector<Index> indices;
  for (Index i = 0; i < model.count; ++i) {
    if (usable[static_cast<std::size_t>(i)]) indices.push_back(i);
  }
  return indices;
}

// Leaves out the Gaussians that are not listed.
void Keep(const std::vector<Index>& kept, SplatModel* model) {
  SplatModel result = *model;
  result.Resize(model->sh_degree, static_cast<Index>(kept.size()));
  for (int a = 0; a < model->num_attributes(); ++a) {
    for (std::size_t i = 0; i < kept.size(); ++i) result.attribute(a)[i] = model->attribute(a)[kept[i]];
  }
  *model = std::move(result);
}

}  // namespace

SplatModel ReadSplatPly(const std::string& path, const ReadSplatOptions& options) {
  const PlyVertices vertices(path);
  SplatModel model;
  model.Resize(DegreeOf(path, vertices.CountWithPrefix("f_rest_")), 0);
  std::vector<FileColumn> columns = FileColumns(model.sh_degree);
  std::erase_if(columns, [](const FileColumn& column) { return column.attribute < 0; });
  for (const FileColumn& column : columns) {
    if (!vertices.Has(column.property)) {
      Fail("{}: not a splat in the INRIA layout: its vertices have no property {}", path, column.property);
    }
  }
  if (vertices.count() == 0) Fail("{}: it holds no Gaussians", path);
  model.Resize(model.sh_degree, vertices.count());
  ReadComments(path, vertices.comments(), &model);
  std::vector<PlyVertices::Column<float>> copies;
  copies.reserve(columns.size());
  for (const FileColumn& column : columns) copies.push_back({column.property, model.attribute(column.attribute)});
  vertices.Copy(copies);

  const std::vector<Index> usable = UsableGaussians(model);
  const Index bad = model.count - static_cast<Index>(usable.size());
  if (bad > 0 && (!options.drop_unusable || usable.empty())) {
    Fail("{}: {} of {} Gaussians have values that are not finite or a zero quaternion; remove them, or train again",
         path, bad, model.count);
  }
  if (bad > 0) Keep(usable, &model);
  return model;
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
  VESTA_CHECK(static_cast<Index>(model.data.size()) == model.count * model.num_attributes(),
              "{} values for {} Gaussians of degree {}", model.data.size(), model.count, model.sh_degree);
  const std::vector<FileColumn> columns = FileColumns(model.sh_degree);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (model.has_background) {
    const auto& b = model.background;
    header += fmt::format("comment {} {} {} {}\n", kBackgroundComment, b[0], b[1], b[2]);
  }
  if (model.origin != std::array<double, 3>{}) {
    const auto& o = model.origin;
    header += fmt::format("comment {} {} {} {}\n", kOriginComment, o[0], o[1], o[2]);
  }
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
        rows.push_back(column.attribute < 0 ? 0.0f : model.attribute(column.attribute)[i]);
      }
    }
    file.Write({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(float)});
  }
}

WorldPoints ReadPointPly(const std::string& path) {
  const PlyVertices vertices(path);
  if (vertices.count() == 0) Fail("{}: it holds no points", path);
  const auto n = static_cast<std::size_t>(vertices.count());
  const char* const axes[3] = {"x", "y", "z"};
  const char* const channels[3] = {"red", "green", "blue"};
  const bool has_colors = std::ranges::all_of(channels, [&](const char* name) { return vertices.Has(name); });
  std::vector<double> positions(3 * n);
  std::vector<float> colors(3 * n, 0.5f);
  const auto columns = [n](const char* const(&names)[3], auto* values) {
    std::vector<PlyVertices::Column<std::remove_pointer_t<decltype(values)>>> result;
    for (std::size_t k = 0; k < 3; ++k) result.push_back({names[k], values + k * n});
    return result;
  };
  vertices.Copy(columns(axes, positions.data()));
  if (has_colors) vertices.Copy(columns(channels, colors.data()));

  WorldPoints cloud;
  cloud.positions.resize(n);
  cloud.colors.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double position = positions[k * n + i];
      const float color = colors[k * n + i] / (has_colors ? vertices.FullScale(channels[k]) : 1.0f);
      if (!std::isfinite(static_cast<float>(position)) || !std::isfinite(color)) {
        Fail("{}: point {} is not finite; remove it", path, i);
      }
      cloud.positions[i][k] = position;
      cloud.colors[i][k] = std::clamp(color, 0.0f, 1.0f);
    }
  }
  return cloud;
}

}  // namespace vesta::gs
