// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/splat_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/io/splats/compressed_ply.h"
#include "splatting/io/splats/ply.h"
#include "splatting/io/splats/spz.h"

namespace vesta::gs {
namespace {

// In order.
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

}  // namespace

void TakeUsableGaussians(const std::string& path, const ReadSplatOptions& options, SplatModel* model) {
  const std::vector<Index> usable = UsableGaussians(*model);
  const Index bad = model->count - static_cast<Index>(usable.size());
  if (bad == 0) return;
  if (!options.drop_unusable || usable.empty()) {
    Fail(kBadFile,
         "{}: {} of {} Gaussians have values that are not finite or a zero quaternion; remove them, or train again",
         path, bad, model->count);
  }
  *model = InOrder(std::move(*model), usable);
}

void CheckDrawable(const std::string& path, const SplatModel& model) {
  VESTA_CHECK(model.sh_degree >= 0 && model.sh_degree <= 3, "degree {}", model.sh_degree);
  VESTA_CHECK(static_cast<Index>(model.data.size()) == model.Size(), "{} values for {} Gaussians of degree {}",
              model.data.size(), model.count, model.sh_degree);
  const Index bad = model.count - static_cast<Index>(UsableGaussians(model).size());
  if (bad > 0) {
    Fail(
        kBadArgument,
        "{}: {} of {} Gaussians have values that are not finite or a zero quaternion, which this format has no numbers "
        "for; remove them, or train again",
        path, bad, model.count);
  }
}

namespace {

using Writer = void (*)(const std::string& path, const SplatModel& model);

// The first that fits counts.
constexpr struct {
  std::string_view extension;
  Writer write;
} kFormats[] = {{".compressed.ply", WriteCompressedPly}, {".ply", WriteSplatPly}, {".spz", WriteSpz}};

Writer WriterFor(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; };
  std::transform(name.begin(), name.end(), name.begin(), lower);
  for (const auto& format : kFormats) {
    if (name.ends_with(format.extension)) return format.write;
  }
  Fail(kBadArgument, "{}: the extension says the format: .ply, .compressed.ply or .spz", path);
}

}  // namespace

SplatModel ReadSplat(const std::string& path, const ReadSplatOptions& options) {
  std::string bytes = ReadFile(path);
  if (bytes.starts_with("NGSP")) {
    Fail(kUnsupported,
         "{}: .spz of version 4 or later, where versions 1 to 3 are read; export it as one of those, or as .ply", path);
  }
  if (bytes.starts_with("\x1f\x8b")) return ReadSpz(path, bytes, options);
  const PlyFile file(path, std::move(bytes));
  return IsCompressedPly(file) ? ReadCompressedPly(file, options) : ReadSplatPly(file, options);
}

void WriteSplat(const std::string& path, const SplatModel& model) { WriterFor(path)(path, model); }

void CheckSplatExtension(const std::string& path) { WriterFor(path); }

}  // namespace vesta::gs
