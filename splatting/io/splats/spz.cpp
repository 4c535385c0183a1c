// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/spz.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {
namespace {

constexpr std::uint32_t kMagic = 0x5053474e;  // "NGSP"
constexpr std::uint32_t kWrittenVersion = 2;
constexpr std::uint8_t kHasExtensions = 2;  // bit of Header::flags
// Fraction bits of the 24-bit fixed-point means: usual, and maximum in writing and reading.
constexpr int kUsualFractionBits = 12, kMostWritten = 24, kMostRead = 30;
constexpr double kLargestFixed = (1 << 23) - 1;
constexpr double kLeastLogScale = -10, kLogScalesPerUnit = 16, kGreatestLogScale = kLeastLogScale + 255 / 16.0;
constexpr double kColorScale = 0.15 * 255, kColorZero = 127.5;
constexpr double kQuaternionScale = 127.5;
constexpr double kShScale = 128, kShZero = 128;

// The first 16 bytes of the file.
struct Header {
  std::uint32_t magic = kMagic, version = kWrittenVersion, count = 0;
  std::uint8_t sh_degree = 0, fraction_bits = 0, flags = 0, reserved = 0;
};
static_assert(sizeof(Header) == 16);

// Bytes per Gaussian in the arrays after the header, in their order.
struct Widths {
  Index mean, opacity = 1, color = 3, scale = 3, rotation, sh;

  explicit Widths(const Header& header)
      : mean(header.version == 1 ? 6 : 9),
        rotation(header.version >= 3 ? 4 : 3),
        sh(splat::NumHigherHarmonics(header.sh_degree)) {}
  Index Sum() const { return mean + opacity + color + scale + rotation + sh; }
};

// Byte may be const.
template <class Byte>
struct Arrays {
  Byte *mean, *opacity, *color, *scale, *rotation, *sh;

  Arrays(Byte* bytes, const Widths& widths, Index count)
      : mean(bytes),
        opacity(mean + count * widths.mean),
        color(opacity + count * widths.opacity),
        scale(color + count * widths.color),
        rotation(scale + count * widths.scale),
        sh(rotation + count * widths.rotation) {}
};

Header CheckedHeader(const std::string& path, const std::array<char, sizeof(Header)>& bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kMagic) {
    const bool is_ply = std::string_view(bytes.data(), bytes.size()).starts_with("ply");
    Fail(kBadFile, "{}: {}", path,
         is_ply ? "a .ply compressed with gzip; unpack it first: gunzip" : "a gzip file, but not .spz");
  }
  if (header.version < 1 || header.version > 3) {
    Fail(kUnsupported, "{}: .spz version {} is not supported; export it as version 1 to 3, or as .ply", path,
         header.version);
  }
  if (header.sh_degree > 3) {
    Fail(kBadFile, "{}: SH degree {} is not supported; the maximum is 3", path, header.sh_degree);
  }
  if (header.fraction_bits > kMostRead) {
    Fail(kBadFile, "{}: {} fraction bits in 24-bit positions; the file is damaged, copy or export it again", path,
         header.fraction_bits);
  }
  if (header.count == 0) Fail(kBadFile, "{}: it holds no Gaussians", path);
  return header;
}

// From IEEE 754 binary16.
float FromHalfBits(std::uint16_t bits) {
  const int exponent = bits >> 10 & 0x1f, fraction = bits & 0x3ff;
  if (exponent == 0x1f) return std::numeric_limits<float>::quiet_NaN();  // also for infinity, which is not usable
  const float magnitude = exponent == 0 ? std::ldexp(static_cast<float>(fraction), -24)
                                        : std::ldexp(static_cast<float>(fraction + 0x400), exponent - 25);
  return bits & 0x8000 ? -magnitude : magnitude;
}

// A signed 24-bit integer.
std::int32_t ReadFixed(const std::uint8_t* bytes) {
  const std::uint32_t low = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
  return static_cast<std::int32_t>(low << 8 | static_cast<std::uint32_t>(bytes[2]) << 24) >> 8;
}

void WriteFixed(std::int32_t value, std::uint8_t* bytes) {
  for (int k = 0; k < 3; ++k) bytes[k] = static_cast<std::uint8_t>(value >> 8 * k);
}

std::uint8_t ToByte(double value) { return static_cast<std::uint8_t>(std::clamp(std::round(value), 0.0, 255.0)); }

// Returns w, x, y, z. Versions 1 and 2 do not store w.
std::array<double, 4> ReadRotation(std::uint32_t version, const std::uint8_t* bytes) {
  SmallestThree three{3, {}};  // order: x, y, z, w
  if (version < 3) {
    for (std::size_t k = 0; k < 3; ++k) three.rest[k] = bytes[k] / kQuaternionScale - 1;
  } else {
    // From the highest bit: two bits for the index of the largest number, then a sign and nine bits for each other.
    std::uint32_t bits = 0;
    std::memcpy(&bits, bytes, sizeof(bits));
    three.largest = static_cast<int>(bits >> 30);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t number = bits >> (20 - 10 * k) & 0x3ff;
      const double magnitude = kLargestOfSmallest * (number & 0x1ff) / 0x1ff;
      three.rest[k] = number & 0x200 ? -magnitude : magnitude;
    }
  }
  const auto [x, y, z, w] = FromSmallestThree(three);
  return {w, x, y, z};
}

// Stores x, y and z of the quaternion w, x, y, z in three bytes. Recomputing a small w from them is inaccurate, so of
// the 24 quaternions for the Gaussian, the one with the smallest error is stored. Returns its order of the log-scales.
std::array<int, 3> WriteRotation(const std::array<double, 4>& q, std::uint8_t* bytes) {
  std::array<int, 3> axes{};
  double nearest = 0;
  for (const CubeTurn& turn : CubeTurns()) {
    const std::array<double, 4> turned = Product(q, turn.quaternion);
    double norm2 = 0;
    for (const double value : turned) norm2 += value * value;
    const double scale = std::copysign(1 / std::sqrt(norm2), turned[0]);
    std::array<std::uint8_t, 3> rounded{};
    for (std::size_t k = 0; k < 3; ++k) rounded[k] = ToByte((scale * turned[k + 1] + 1) * kQuaternionScale);
    const std::array<double, 4> again = ReadRotation(kWrittenVersion, rounded.data());
    double product = 0, again2 = 0;
    for (std::size_t k = 0; k < 4; ++k) product += scale * turned[k] * again[k], again2 += again[k] * again[k];
    if (product <= nearest * std::sqrt(again2)) continue;
    nearest = product / std::sqrt(again2);
    axes = turn.axes;
    std::copy(rounded.begin(), rounded.end(), bytes);
  }
  return axes;
}

// Skips data that other programs append, but rejects extensions that could change the splat's meaning.
void SkipExtensions(const std::string& path, GzipReader* reader) {
  constexpr std::uint32_t kCameraLimits = 0xadbe0002, kMostSkipped = 1 << 16;
  std::array<std::uint32_t, 2> head{};  // type, number of bytes
  for (;;) {
    const std::size_t read = reader->Read(reinterpret_cast<char*>(head.data()), sizeof(head));
    if (read == 0) return;
    if (read < sizeof(head)) Fail(kBadFile, "{}: the extension after the splat is truncated", path);
    if (head[0] != kCameraLimits || head[1] > kMostSkipped) {
      Fail(kUnsupported, "{}: unknown extension of type {:#x}; export the file without it", path, head[0]);
    }
    std::string ignored(head[1], '\0');
    if (reader->Read(ignored.data(), ignored.size()) < ignored.size()) {
      Fail(kBadFile, "{}: the extension after the splat is truncated", path);
    }
  }
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::string_view rest = text, line;
  while (NextLine(&rest, &line)) lines.emplace_back(line);
  return lines;
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

CubeTurn TurnOf(const std::array<double, 4>& direction) {
  double norm2 = 0;
  for (const double value : direction) norm2 += value * value;
  CubeTurn turn{};
  for (std::size_t k = 0; k < 4; ++k) turn.quaternion[k] = direction[k] / std::sqrt(norm2);
  std::array<double, 9> R{};
  RotationFromQuaternion(turn.quaternion.data(), R.data());
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      if (std::abs(R[3 * row + column]) > 0.5) turn.axes[column] = static_cast<int>(row);
    }
  }
  return turn;
}

// Quaternions along an edge direction of the four-dimensional cube, or along a diagonal of two or of all four axes; one
// of q and -q, the same rotation.
std::array<CubeTurn, 24> MakeTurns() {
  std::array<CubeTurn, 24> turns{};
  std::size_t count = 0;
  const auto add = [&](double w, double x, double y, double z) {
    const double first = w != 0 ? w : x != 0 ? x : y != 0 ? y : z;
    const double norm2 = w * w + x * x + y * y + z * z;
    if (first > 0 && norm2 != 3) turns[count++] = TurnOf({w, x, y, z});
  };
  add(1, 0, 0, 0);
  const std::array<double, 3> parts = {-1, 0, 1};
  for (const double w : parts) {
    for (const double x : parts) {
      for (const double y : parts) {
        for (const double z : parts) {
          const bool is_first = x == 0 && y == 0 && z == 0;
          if (!is_first) add(w, x, y, z);
        }
      }
    }
  }
  VESTA_CHECK(count == turns.size(), "{} turns", count);
  return turns;
}

}  // namespace

SplatModel ReadSpz(const std::string& path, std::vector<std::string>* notes) {
  return ReadSpz(path, ReadFile(path), notes);
}

SplatModel ReadSpz(const std::string& path, std::string_view bytes, std::vector<std::string>* notes) {
  GzipReader reader(path, bytes);
  std::array<char, sizeof(Header)> first{};
  const std::size_t read = reader.Read(first.data(), first.size());
  const auto cut_short = [&] { Fail(kBadFile, "{}: truncated; copy or export it again", path); };
  if (read < first.size()) cut_short();
  const Header header = CheckedHeader(path, first);
  const Widths widths(header);
  const Index count = header.count, size = count * widths.Sum();
  if (size / kMostDeflateExpands > static_cast<Index>(bytes.size())) {
    Fail(kBadFile, "{}: the header counts {} Gaussians, too many for {} bytes; the file is truncated or damaged", path,
         count, bytes.size());
  }
  std::vector<std::uint8_t> body(static_cast<std::size_t>(size));
  if (reader.Read(reinterpret_cast<char*>(body.data()), body.size()) < body.size()) cut_short();
  if (header.flags & kHasExtensions) SkipExtensions(path, &reader);
  char more = 0;
  if (reader.Read(&more, 1) > 0) {
    Fail(kBadFile, "{}: bytes follow the last Gaussian; the file is damaged, copy or export it again", path);
  }

  SplatModel model;
  model.Resize(header.sh_degree, count);
  ReadSplatComments(path, LinesOf(reader.comment()), &model);
  const Arrays<const std::uint8_t> from(body.data(), widths, count);
  const double position_step = std::ldexp(1.0, -header.fraction_bits);
  ParallelForChunks(count, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto set = [&](int attribute, double value) {
        model.attribute(attribute)[i] = HalfTurnSign(attribute) * static_cast<float>(value);
      };
      for (int k = 0; k < 3; ++k) {
        const std::uint8_t* mean = from.mean + i * widths.mean + k * (widths.mean / 3);
        std::uint16_t half = 0;
        std::memcpy(&half, mean, sizeof(half));
        set(splat::kMean + k,
            header.version == 1 ? static_cast<double>(FromHalfBits(half)) : ReadFixed(mean) * position_step);
        set(splat::kLogScale + k, from.scale[3 * i + k] / kLogScalesPerUnit + kLeastLogScale);
        set(splat::kSh + k, (from.color[3 * i + k] - kColorZero) / kColorScale);
      }
      const auto [w, x, y, z] = ReadRotation(header.version, from.rotation + i * widths.rotation);
      set(splat::kQuaternion, w), set(splat::kQuaternion + 1, x);
      set(splat::kQuaternion + 2, y), set(splat::kQuaternion + 3, z);
      model.attribute(splat::kOpacity)[i] = OpacityLogit(from.opacity[i]);
      for (int k = 0; k < widths.sh; ++k) set(splat::kSh + 3 + k, (from.sh[i * widths.sh + k] - kShZero) / kShScale);
    }
  });
  RemoveUnusableGaussians(path, notes, &model);
  return AtStoredDegrees(std::move(model));
}

void WriteSpz(const std::string& path, const SplatModel& model) {
  CheckDrawable(path, model);
  if (model.count == 0) Fail(kBadArgument, "{}: cannot write a splat without Gaussians", path);
  if (model.count > std::numeric_limits<std::uint32_t>::max())
    Fail(kBadArgument, "{}: {} Gaussians are too many", path, model.count);
  Header header;
  header.count = static_cast<std::uint32_t>(model.count);
  header.sh_degree = static_cast<std::uint8_t>(model.sh_degree);
  header.fraction_bits = static_cast<std::uint8_t>(FractionBits(path, model));
  const Widths widths(header);
  std::string bytes(sizeof(header) + static_cast<std::size_t>(model.count * widths.Sum()), '\0');
  std::memcpy(bytes.data(), &header, sizeof(header));
  const Arrays<std::uint8_t> to(reinterpret_cast<std::uint8_t*>(bytes.data()) + sizeof(header), widths, model.count);
  ParallelForChunks(model.count, 1024, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto get = [&](int attribute) {
        return static_cast<double>(HalfTurnSign(attribute) * model.Value(attribute, i));
      };
      const int q = splat::kQuaternion;
      const std::array<int, 3> axes =
          WriteRotation({get(q), get(q + 1), get(q + 2), get(q + 3)}, to.rotation + i * widths.rotation);
      for (int k = 0; k < 3; ++k) {
        const double mean = std::round(std::ldexp(get(splat::kMean + k), header.fraction_bits));
        WriteFixed(static_cast<std::int32_t>(mean), to.mean + 9 * i + 3 * k);
        const double log_scale = get(splat::kLogScale + axes[static_cast<std::size_t>(k)]);
        to.scale[3 * i + k] = ToByte((log_scale - kLeastLogScale) * kLogScalesPerUnit);
        to.color[3 * i + k] = ToByte(get(splat::kSh + k) * kColorScale + kColorZero);
      }
      to.opacity[i] = OpacityByte(model.attribute(splat::kOpacity)[i]);
      for (int k = 0; k < widths.sh; ++k) {
        to.sh[i * widths.sh + k] = ToByte(get(splat::kSh + 3 + k) * kShScale + kShZero);
      }
    }
  });
  std::string comment;
  for (const std::string& line : SplatComments(model)) comment += (comment.empty() ? "" : "\n") + line;
  WriteFileAtomically(path, Gzip(bytes, comment));
}

const std::array<CubeTurn, 24>& CubeTurns() {
  static const std::array<CubeTurn, 24> turns = MakeTurns();
  return turns;
}

std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

}  // namespace vesta::gs
