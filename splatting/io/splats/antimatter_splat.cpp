// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/antimatter_splat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {
namespace {

// Layout: main.js of github.com/antimatter15/splat. Axes are as in INRIA's .ply.
struct SplatRow {
  std::array<float, 3> mean, scale;  // scale: standard deviations
  std::array<std::uint8_t, 3> color;
  std::uint8_t opacity;
  std::array<std::uint8_t, 4> quaternion;  // w, x, y, z
};
static_assert(sizeof(SplatRow) == 32);

constexpr double kQuaternionUnit = 128;   // 1 in a quaternion; zero is stored as 128
constexpr float kMostSplatLogScale = 88;  // e^88 is a finite float

}  // namespace

SplatModel ReadAntimatterSplat(const std::string& path, std::string_view bytes, std::vector<std::string>* notes) {
  if (bytes.empty() || bytes.size() % sizeof(SplatRow) != 0) {
    Fail(kBadFile, "{}: {} bytes, but a .splat has {} for each Gaussian; the file is damaged, copy or export it again",
         path, bytes.size(), sizeof(SplatRow));
  }
  SplatModel model;
  model.Resize(0, static_cast<Index>(bytes.size() / sizeof(SplatRow)));
  ParallelForChunks(model.count, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      SplatRow row;
      std::memcpy(&row, bytes.data() + static_cast<std::size_t>(i) * sizeof(row), sizeof(row));
      for (std::size_t k = 0; k < 3; ++k) {
        const int axis = static_cast<int>(k);
        model.attribute(splat::kMean + axis)[i] = row.mean[k];
        model.attribute(splat::kLogScale + axis)[i] = LogScaleOf(row.scale[k]);
        model.attribute(splat::kSh + axis)[i] = static_cast<float>(DcOf(row.color[k] / 255.0));
      }
      for (std::size_t k = 0; k < 4; ++k) {
        model.attribute(splat::kQuaternion + static_cast<int>(k))[i] =
            static_cast<float>((row.quaternion[k] - kQuaternionUnit) / kQuaternionUnit);
      }
      model.attribute(splat::kOpacity)[i] = OpacityLogit(row.opacity);
    }
  });
  RemoveUnusableGaussians(path, notes, &model);
  return model;
}

void WriteAntimatterSplat(const std::string& path, const SplatModel& model, std::vector<std::string>* notes) {
  CheckDrawable(path, model);
  if (model.count == 0) Fail(kBadArgument, "{}: cannot write a splat without Gaussians", path);
  if (notes != nullptr && model.sh_degree > 0) {
    notes->push_back(
        fmt::format("{}: .splat has no SH bands above 0; bands 1 to {} are left out", path, model.sh_degree));
  }
  if (notes != nullptr && !PlyComments(model).empty()) {
    notes->push_back(
        fmt::format("{}: .splat stores no background, origin, eps2d or antialiasing; they are left out", path));
  }
  std::vector<SplatRow> rows(static_cast<std::size_t>(model.count));
  ParallelForChunks(model.count, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      SplatRow& row = rows[static_cast<std::size_t>(i)];
      for (std::size_t k = 0; k < 3; ++k) {
        const int axis = static_cast<int>(k);
        row.mean[k] = model.attribute(splat::kMean + axis)[i];
        const float log_scale = model.attribute(splat::kLogScale + axis)[i];
        row.scale[k] = std::exp(std::clamp(log_scale, -kMostSplatLogScale, kMostSplatLogScale));
        row.color[k] = ToByte(ColorOf(static_cast<double>(model.attribute(splat::kSh + axis)[i])) * 255);
      }
      std::array<double, 4> q{};
      double norm2 = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        q[k] = static_cast<double>(model.attribute(splat::kQuaternion + static_cast<int>(k))[i]);
        norm2 += q[k] * q[k];
      }
      for (std::size_t k = 0; k < 4; ++k)
        row.quaternion[k] = ToByte(q[k] / std::sqrt(norm2) * kQuaternionUnit + kQuaternionUnit);
      row.opacity = OpacityByte(model.attribute(splat::kOpacity)[i]);
    }
  });
  WriteFileAtomically(path, {reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(SplatRow)});
}

}  // namespace vesta::gs
