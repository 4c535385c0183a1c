// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/spz.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/splat_file.h"
#include "splatting/io/splats/spz_rotation.h"

namespace vesta::gs {
namespace {

// Fraction bits of the 24-bit fixed-point means: usual, and maximum in writing.
constexpr int kUsualFractionBits = 12, kMostWritten = 24;
constexpr double kLargestFixed = (1 << 23) - 1;
constexpr double kLeastLogScale = -10, kLogScalesPerUnit = 16, kGreatestLogScale = kLeastLogScale + 255 / 16.0;
constexpr double kColorScale = 0.15 * 255, kColorZero = 127.5;
constexpr double kShScale = 128, kShZero = 128;

// A signed 24-bit integer.
std::int32_t ReadFixed(const std::uint8_t* bytes) {
  const std::uint32_t low = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
  return static_cast<std::int32_t>(low << 8 | static_cast<std::uint32_t>(bytes[2]) << 24) >> 8;
}

void WriteFixed(std::int32_t value, std::uint8_t* bytes) {
  for (int k = 0; k < 3; ++k) bytes[k] = static_cast<std::uint8_t>(value >> 8 * k);
}

// Median of the logarithm of the geometric mean of the three standard deviations.
double MedianLogScale(const SplatModel& model) {
  std::vector<float> sizes(static_cast<std::size_t>(model.count));
  const float* scale = model.attribute(splat::kLogScale);
  for (Index i = 0; i < model.count; ++i) {
    sizes[static_cast<std::size_t>(i)] = (scale[i] + scale[model.count + i] + scale[2 * model.count + i]) / 3;
  }
  return static_cast<double>(Median(std::move(sizes)));
}

// Steps of an eighth of the median Gaussian size; 12 to 24 bits, or fewer if the means do not fit otherwise.
int FractionBits(const std::string& path, const SplatModel& model) {
  const double size = MedianLogScale(model);
  if (size < kLeastLogScale || size > kGreatestLogScale) {
    Fail(kBadArgument,
         "{}: half of the Gaussians are {} than .spz can store: e^{:.0f} units, but the range is e^-10 to e^5.9; write "
         "a .ply",
         path, size < 0 ? "smaller" : "larger", size);
  }
  double farthest = 0;
  for (int k = 0; k < 3; ++k) {
    const float* mean = model.attribute(splat::kMean + k);
    for (Index i = 0; i < model.count; ++i) farthest = std::max(farthest, std::abs(static_cast<double>(mean[i])));
  }
  const double wanted = 3 - size / std::log(2.0);
  int bits = std::clamp(static_cast<int>(std::ceil(wanted)), kUsualFractionBits, kMostWritten);
  while (bits > 0 && std::round(std::ldexp(farthest, bits)) > kLargestFixed) --bits;
  if (bits < wanted - 3 || std::round(std::ldexp(farthest, bits)) > kLargestFixed) {
    Fail(kBadArgument,
         "{}: a mean {:.3g} units from the origin is too far out for the 24 bits of .spz; remove it, or write a .ply",
         path, farthest);
  }
  return bits;
}

// Mean k of a Gaussian from its bytes. Version 1 has half floats.
double ReadMean(const SpzFile& file, Index i, int k) {
  const std::uint8_t* bytes = file.arrays[kSpzMean].data() + file.Width(kSpzMean) * i;
  if (file.version > 1) return std::ldexp(ReadFixed(bytes + 3 * k), -file.fraction_bits);
  std::uint16_t half = 0;
  std::memcpy(&half, bytes + 2 * k, sizeof(half));
  return static_cast<double>(FromHalfBits(half));
}

}  // namespace

bool IsSpz(std::string_view bytes) {
  // RFC 1952: the number of gzip, method deflate, and five flags.
  const bool is_gzip =
      bytes.starts_with("\x1f\x8b\x08") && bytes.size() > 3 && static_cast<std::uint8_t>(bytes[3]) < 32;
  return is_gzip || bytes.starts_with("NGSP");
}

SplatModel ReadSpz(const std::string& path, std::vector<std::string>* notes) {
  return ReadSpz(path, ReadFile(path), notes);
}

SplatModel ReadSpz(const std::string& path, std::string_view bytes, std::vector<std::string>* notes) {
  const SpzFile file = ReadSpzFile(path, bytes);
  const Index count = file.count;
  SplatModel model;
  model.Resize(std::min(file.sh_degree, splat::kMaxShDegree), count);
  if (file.sh_degree > splat::kMaxShDegree && notes != nullptr) {
    notes->push_back(fmt::format("{}: SH band {} is left out", path, file.sh_degree));
  }
  model.antialiased = file.antialiased;
  ReadSplatComments(path, file.comments, &model);
  const auto& arrays = file.arrays;
  const int num_sh = splat::NumHigherHarmonics(model.sh_degree);
  ParallelForChunks(count, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto set = [&](int attribute, double value) {
        model.attribute(attribute)[i] = HalfTurnSign(attribute) * static_cast<float>(value);
      };
      const auto row = [&](SpzArray array) { return arrays[array].data() + i * file.Width(array); };
      for (int k = 0; k < 3; ++k) {
        set(splat::kMean + k, ReadMean(file, i, k));
        set(splat::kLogScale + k, row(kSpzScale)[k] / kLogScalesPerUnit + kLeastLogScale);
        set(splat::kSh + k, (row(kSpzColor)[k] - kColorZero) / kColorScale);
      }
      const std::array<double, 4> q = ReadSpzRotation(file.version, row(kSpzRotation));
      for (int k = 0; k < 4; ++k) set(splat::kQuaternion + k, q[static_cast<std::size_t>(k)]);
      model.attribute(splat::kOpacity)[i] = OpacityLogit(*row(kSpzOpacity));
      for (int k = 0; k < num_sh; ++k) set(splat::kSh + 3 + k, (row(kSpzSh)[k] - kShZero) / kShScale);
    }
  });
  RemoveUnusableGaussians(path, notes, &model);
  return AtStoredDegrees(std::move(model));
}

void WriteSpz(const std::string& path, const SplatModel& model, std::uint32_t version) {
  VESTA_CHECK(version == kUniversalSpz || version == kLatestSpz, "{}: .spz version {} cannot be written", path,
              version);
  CheckDrawable(path, model);
  if (model.count == 0) Fail(kBadArgument, "{}: cannot write a splat without Gaussians", path);
  if (model.count > std::numeric_limits<std::uint32_t>::max())
    Fail(kBadArgument, "{}: {} Gaussians are too many", path, model.count);
  SpzFile file;
  file.version = version;
  file.count = model.count;
  file.sh_degree = model.sh_degree;
  file.fraction_bits = FractionBits(path, model);
  file.antialiased = model.antialiased;
  file.comments = SplatComments(model);
  for (int array = 0; array < kNumSpzArrays; ++array) {
    file.arrays[static_cast<std::size_t>(array)].resize(static_cast<std::size_t>(model.count * file.Width(array)));
  }
  ParallelForChunks(model.count, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto get = [&](int attribute) {
        return static_cast<double>(HalfTurnSign(attribute) * model.Value(attribute, i));
      };
      const auto row = [&](SpzArray array) { return file.arrays[array].data() + i * file.Width(array); };
      const int q = splat::kQuaternion;
      const std::array<int, 3> axes =
          WriteSpzRotation(version, {get(q), get(q + 1), get(q + 2), get(q + 3)}, row(kSpzRotation));
      for (int k = 0; k < 3; ++k) {
        const double mean = std::round(std::ldexp(get(splat::kMean + k), file.fraction_bits));
        WriteFixed(static_cast<std::int32_t>(mean), row(kSpzMean) + 3 * k);
        const double log_scale = get(splat::kLogScale + axes[static_cast<std::size_t>(k)]);
        row(kSpzScale)[k] = ToByte((log_scale - kLeastLogScale) * kLogScalesPerUnit);
        row(kSpzColor)[k] = ToByte(get(splat::kSh + k) * kColorScale + kColorZero);
      }
      *row(kSpzOpacity) = OpacityByte(model.attribute(splat::kOpacity)[i]);
      for (int k = 0; k < file.Width(kSpzSh); ++k)
        row(kSpzSh)[k] = ToByte(get(splat::kSh + 3 + k) * kShScale + kShZero);
    }
  });
  WriteFileAtomically(path, SpzFileBytes(file));
}

}  // namespace vesta::gs
