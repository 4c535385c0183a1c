// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/splat_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/io/splats/antimatter_splat.h"
#include "splatting/io/splats/compressed_ply.h"
#include "splatting/io/splats/glb.h"
#include "splatting/io/splats/ksplat.h"
#include "splatting/io/splats/ply.h"
#include "splatting/io/splats/sog.h"
#include "splatting/io/splats/spz.h"

namespace vesta::gs {
namespace {

// In ascending order.
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
      for (Index i = begin; i < std::min(end, model.Rows(a)); ++i) {
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

using Notes = std::vector<std::string>*;

// Ignores the case of the path. The extension must be in lower case.
bool HasExtension(std::string_view path, std::string_view extension) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; };
  return path.size() > extension.size() && std::equal(extension.rbegin(), extension.rend(), path.rbegin(),
                                                      [&](char wanted, char c) { return wanted == lower(c); });
}

SplatModel ReadAnyPly(const std::string& path, std::string& bytes, Notes notes) {
  const PlyFile file(path, std::move(bytes));
  return IsCompressedPly(file) ? ReadCompressedPly(file, notes) : ReadSplatPly(file, notes);
}

bool IsPly(std::string_view bytes) { return bytes.starts_with("ply\n") || bytes.starts_with("ply\r"); }

// A format has one row in each table that applies. The first match is used. A magic number has at least 28 bits: as the
// first mean of a .splat, it would be below 1e-18 or above 1e10 units.
constexpr struct {
  const char* names;
  bool (*recognises)(std::string_view path, std::string_view bytes);
  SplatModel (*read)(const std::string& path, std::string& bytes, Notes notes);  // may move the bytes
} kReaders[] = {
    {".ply, .compressed.ply", [](std::string_view, std::string_view bytes) { return IsPly(bytes); }, ReadAnyPly},
    {".spz", [](std::string_view, std::string_view bytes) { return IsSpz(bytes); },
     [](const std::string& path, std::string& bytes, Notes notes) { return ReadSpz(path, bytes, notes); }},
    {".sog", [](std::string_view, std::string_view bytes) { return IsSog(bytes); },
     [](const std::string& path, std::string& bytes, Notes notes) { return ReadSog(path, bytes, notes); }},
    // Formats without a magic number follow. Their extension decides.
    {".ksplat", [](std::string_view path, std::string_view) { return HasExtension(path, ".ksplat"); },
     [](const std::string& path, std::string& bytes, Notes notes) {
       return ReadKsplat(path, std::move(bytes), notes);
     }},
    {".splat", [](std::string_view path, std::string_view) { return HasExtension(path, ".splat"); },
     [](const std::string& path, std::string& bytes, Notes notes) { return ReadAntimatterSplat(path, bytes, notes); }},
};

constexpr struct {
  std::string_view extension;
  void (*write)(const std::string& path, const SplatModel& model, const WriteSplatOptions& options);
} kWriters[] = {
    {".compressed.ply", [](const std::string& path, const SplatModel& model,
                           const WriteSplatOptions&) { WriteCompressedPly(path, model); }},
    {".ply",
     [](const std::string& path, const SplatModel& model, const WriteSplatOptions&) { WriteSplatPly(path, model); }},
    {".spz", [](const std::string& path, const SplatModel& model,
                const WriteSplatOptions& options) { WriteSpz(path, model, options.spz_version); }},
    {".splat", [](const std::string& path, const SplatModel& model,
                  const WriteSplatOptions& options) { WriteAntimatterSplat(path, model, options.notes); }},
    {".sog", [](const std::string& path, const SplatModel& model, const WriteSplatOptions&) { WriteSog(path, model); }},
    {".glb", [](const std::string& path, const SplatModel& model, const WriteSplatOptions&) { WriteGlb(path, model); }},
};

// For messages: "a, b, c".
std::string NamesOfReaders() {
  std::string names;
  for (const auto& reader : kReaders) names += (names.empty() ? "" : ", ") + std::string(reader.names);
  return names;
}

auto WriterFor(const std::string& path) {
  std::string names;
  for (const auto& format : kWriters) {
    if (HasExtension(path, format.extension)) return format.write;
    names += (names.empty() ? "" : ", ") + std::string(format.extension);
  }
  Fail(kBadArgument, "{}: unknown extension; use one of {}", path, names);
}

constexpr std::string_view kBackground = "vesta background", kOrigin = "vesta origin", kEps2d = "vesta eps2d",
                           kAntialiased = "SplatRenderMode: mip";

// Reads the numbers after a comment with this beginning; each must satisfy is_valid. Returns false without such a
// comment.
template <class T, std::size_t N>
bool ReadComment(const std::string& path, const std::vector<std::string>& comments, std::string_view beginning,
                 const char* what, bool (*is_valid)(double), std::array<T, N>* numbers) {
  bool is_there = false;
  for (std::string_view comment : comments) {
    if (!comment.starts_with(beginning)) continue;
    comment.remove_prefix(beginning.size());
    for (T& number : *numbers) {
      double value = 0;
      if (!ParseNumber(NextWord(&comment), &value) || !is_valid(value)) {
        Fail(kBadFile, "{}: the comment '{}' is not followed by {}; correct or remove it", path, beginning, what);
      }
      number = static_cast<T>(value);
    }
    is_there = true;
  }
  return is_there;
}

}  // namespace

void RemoveUnusableGaussians(const std::string& path, std::vector<std::string>* notes, SplatModel* model) {
  const std::vector<Index> usable = UsableGaussians(*model);
  const Index bad = model->count - static_cast<Index>(usable.size());
  if (bad == 0) return;
  if (usable.empty()) {
    Fail(kBadFile, "{}: all {} Gaussians have values that are not finite or a zero quaternion; train again", path, bad);
  }
  if (notes != nullptr) {
    notes->push_back(
        fmt::format("{}: {} of {} Gaussians have values that are not finite or a zero quaternion, and are left out",
                    path, bad, model->count));
  }
  *model = InOrder(std::move(*model), usable);
}

void CheckDrawable(const std::string& path, const SplatModel& model) {
  VESTA_CHECK(model.sh_degree >= 0 && model.sh_degree <= 3, "degree {}", model.sh_degree);
  VESTA_CHECK(static_cast<Index>(model.data.size()) == model.Size(), "{} values for {} Gaussians of degree {}",
              model.data.size(), model.count, model.sh_degree);
  const Index bad = model.count - static_cast<Index>(UsableGaussians(model).size());
  if (bad > 0) {
    Fail(kBadArgument,
         "{}: {} of {} Gaussians have values that are not finite or a zero quaternion, which this format cannot "
         "store; remove them, or train again",
         path, bad, model.count);
  }
}

SplatModel ReadSplat(const std::string& path, std::vector<std::string>* notes) {
  std::string bytes = ReadFile(path);
  if (bytes.starts_with("glTF")) {
    Fail(kUnsupported, "{}: .glb is not read, only written; use the splat from which it was made", path);
  }
  for (const auto& format : kReaders) {
    if (format.recognises(path, bytes)) return format.read(path, bytes, notes);
  }
  Fail(kBadFile, "{}: not a splat in a format that vesta reads ({}); export it in one of them", path, NamesOfReaders());
}

void WriteSplat(const std::string& path, const SplatModel& model, const WriteSplatOptions& options) {
  WriterFor(path)(path, model, options);
}

void CheckSplatExtension(const std::string& path) { WriterFor(path); }

std::vector<std::string> SplatComments(const SplatModel& model) {
  std::vector<std::string> comments;
  const auto& [r, g, b] = model.background;
  const auto& [x, y, z] = model.origin;
  if (model.has_background) comments.push_back(fmt::format("{} {} {} {}", kBackground, r, g, b));
  if (model.origin != std::array<double, 3>{}) comments.push_back(fmt::format("{} {} {} {}", kOrigin, x, y, z));
  VESTA_CHECK(splat::IsValidEps2d(model.eps2d), "a splat with eps2d of {} pixels^2", model.eps2d);
  if (model.eps2d != splat::kEps2d) comments.push_back(fmt::format("{} {}", kEps2d, model.eps2d));
  return comments;
}

std::vector<std::string> PlyComments(const SplatModel& model) {
  std::vector<std::string> comments = SplatComments(model);
  if (model.antialiased) comments.insert(comments.begin(), std::string(kAntialiased));
  return comments;
}

void ReadSplatComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model) {
  const auto is_color = [](double value) { return value >= 0 && value <= 1; };
  const auto is_place = [](double value) {
    return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
  };
  model->has_background =
      ReadComment(path, comments, kBackground, "three numbers in 0..1", +is_color, &model->background);
  ReadComment(path, comments, kOrigin, "three finite numbers", +is_place, &model->origin);
  std::array<double, 1> eps2d{model->eps2d};
  const std::string what = fmt::format("a number in {}..{}", splat::kMinEps2d, splat::kMaxEps2d);
  ReadComment(path, comments, kEps2d, what.c_str(), &splat::IsValidEps2d, &eps2d);
  model->eps2d = eps2d[0];
  if (std::ranges::find(comments, kAntialiased) != comments.end()) model->antialiased = true;
}

}  // namespace vesta::gs
