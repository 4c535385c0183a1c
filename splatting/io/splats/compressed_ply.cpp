// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/compressed_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/ply_file.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {
namespace {

constexpr Index kChunk = 256;
constexpr double kMostLogScale = 40;

// Bounded values: means, log-scales and colours, three each.
constexpr std::size_t kBounded = 9, kFirstColor = 6;
constexpr const char* kWords[] = {"packed_position", "packed_rotation", "packed_scale", "packed_color"};
enum Word { kPosition, kRotation, kScale, kColor, kNumWords };

// The properties of a chunk in the order of the file: minima and maxima of three values each.
struct BoundName {
  const char* name;
  std::size_t bounded;
  bool is_max;
};
constexpr BoundName kBounds[] = {{"min_x", 0, false},       {"min_y", 1, false},       {"min_z", 2, false},
                                 {"max_x", 0, true},        {"max_y", 1, true},        {"max_z", 2, true},
                                 {"min_scale_x", 3, false}, {"min_scale_y", 4, false}, {"min_scale_z", 5, false},
                                 {"max_scale_x", 3, true},  {"max_scale_y", 4, true},  {"max_scale_z", 5, true},
                                 {"min_r", 6, false},       {"min_g", 7, false},       {"min_b", 8, false},
                                 {"max_r", 6, true},        {"max_g", 7, true},        {"max_b", 8, true}};

struct Bounds {
  std::array<double, kBounded> min, max;
};

// ToBits: a number in 0..1 as an integer of `bits` bits. FromBits: the inverse, for the lowest bits of a word.
std::uint32_t ToBits(double value, int bits) {
  const double most = (1 << bits) - 1;
  return static_cast<std::uint32_t>(std::clamp(std::round(value * most), 0.0, most));
}
double FromBits(std::uint32_t word, int bits) {
  const std::uint32_t most = (1u << bits) - 1;
  return static_cast<double>(word & most) / most;
}

// Three numbers in 0..1 with 11, 10 and 11 bits, the first in the highest bits.
constexpr int kThreeBits[] = {11, 10, 11}, kThreeShifts[] = {21, 11, 0};

std::uint32_t PackRotation(const std::array<double, 4>& wxyz) {
  const SmallestThree three = ToSmallestThree(wxyz);
  auto word = static_cast<std::uint32_t>(three.largest);
  for (const double value : three.rest) word = word << 10 | ToBits(value / (2 * kLargestOfSmallest) + 0.5, 10);
  return word;
}

std::array<double, 4> UnpackRotation(std::uint32_t word) {
  SmallestThree three{static_cast<int>(word >> 30), {}};
  for (std::size_t k = 0; k < 3; ++k)
    three.rest[k] = (FromBits(word >> (20 - 10 * k), 10) - 0.5) * 2 * kLargestOfSmallest;
  return FromSmallestThree(three);
}

// A coefficient in -4..4, as in SuperSplat: the centre of one of 256 intervals; the first and the last byte are the
// limits.
double ShOfByte(std::uint8_t byte) { return byte == 0 ? -4 : byte == 255 ? 4 : (byte + 0.5) / 32 - 4; }

std::uint8_t ByteOfSh(double sh) {
  return static_cast<std::uint8_t>(std::clamp(std::floor((sh + 4) * 32), 0.0, 255.0));
}

int DegreeOf(const PlyFile& file, const PlyTable& sh) {
  const int num_rest = sh.CountWithPrefix("f_rest_");
  for (int degree = 1; degree <= 3; ++degree) {
    if (num_rest == splat::NumHigherHarmonics(degree)) return degree;
  }
  Fail(kBadFile, "{}: {} properties f_rest_* of sh; a splat of SH degree 1, 2 or 3 has 9, 24 or 45", file.path(),
       num_rest);
}

std::vector<Bounds> ReadBounds(const PlyFile& file, const PlyTable& chunks) {
  const auto n = static_cast<std::size_t>(chunks.count());
  std::vector<Bounds> bounds(n);
  std::vector<double> column(n);
  for (const auto& [name, bounded, is_max] : kBounds) {
    const bool is_color = bounded >= kFirstColor;
    if (is_color && !chunks.Has("min_r")) {
      std::fill(column.begin(), column.end(), is_max ? 1.0 : 0.0);
    } else {
      chunks.Copy<double>({{name, column.data()}});
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(column[i])) {
        Fail(kBadFile, "{}: {} of chunk {} is not finite; the file is damaged, copy or export it again", file.path(),
             name, i);
      }
      (is_max ? bounds[i].max : bounds[i].min)[bounded] = column[i];
    }
  }
  return bounds;
}

// The property must have this integer type.
std::vector<double> ReadWhole(const PlyFile& file, const PlyTable& table, const std::string& property, PlyType type) {
  if (!table.Has(property, type) || file.is_ascii()) {
    Fail(kBadFile, "{}: property {} of the compressed splat is missing or has the wrong type; export it again",
         file.path(), property);
  }
  std::vector<double> values(static_cast<std::size_t>(table.count()));
  table.Copy<double>({{property, values.data()}});
  return values;
}

void ReadSh(const PlyFile& file, const PlyTable& sh, SplatModel* model) {
  const int rest = ShCoefficients(model->sh_degree) - 1;
  for (int i = 0; i < 3 * rest; ++i) {
    const std::vector<double> bytes = ReadWhole(file, sh, fmt::format("f_rest_{}", i), PlyType::kUint8);
    const int channel = i / rest, coefficient = 1 + i % rest;
    float* values = model->attribute(splat::kSh + 3 * coefficient + channel);
    for (Index k = 0; k < model->count; ++k) {
      values[k] = static_cast<float>(ShOfByte(static_cast<std::uint8_t>(bytes[static_cast<std::size_t>(k)])));
    }
  }
}

// The attributes with bounds, and their values as stored.
constexpr int kAttributes[kBounded] = {splat::kMean,     splat::kMean + 1,     splat::kMean + 2,
                                       splat::kLogScale, splat::kLogScale + 1, splat::kLogScale + 2,
                                       splat::kSh,       splat::kSh + 1,       splat::kSh + 2};

double BoundedOf(const SplatModel& model, std::size_t bounded, Index i) {
  const auto value = static_cast<double>(model.attribute(kAttributes[bounded])[i]);
  if (bounded >= kFirstColor) return ColorOf(value);
  return bounded < 3 ? value : std::clamp(value, -kMostLogScale, kMostLogScale);
}

// Rounded to float.
Bounds BoundsOf(const SplatModel& model, Index begin, Index end) {
  Bounds bounds;
  for (std::size_t b = 0; b < kBounded; ++b) {
    bounds.min[b] = bounds.max[b] = BoundedOf(model, b, begin);
    for (Index i = begin; i < end; ++i) {
      bounds.min[b] = std::min(bounds.min[b], BoundedOf(model, b, i));
      bounds.max[b] = std::max(bounds.max[b], BoundedOf(model, b, i));
    }
    bounds.min[b] = static_cast<double>(static_cast<float>(bounds.min[b]));
    bounds.max[b] = static_cast<double>(static_cast<float>(bounds.max[b]));
  }
  return bounds;
}

std::array<std::uint32_t, kNumWords> Pack(const SplatModel& model, const Bounds& bounds, Index i) {
  const auto part = [&](std::size_t b) {
    const double extent = bounds.max[b] - bounds.min[b];
    return extent > 0 ? (BoundedOf(model, b, i) - bounds.min[b]) / extent : 0.0;
  };
  std::array<std::uint32_t, kNumWords> words{};
  for (std::size_t k = 0; k < 3; ++k) {
    words[kPosition] |= ToBits(part(k), kThreeBits[k]) << kThreeShifts[k];
    words[kScale] |= ToBits(part(3 + k), kThreeBits[k]) << kThreeShifts[k];
    words[kColor] = words[kColor] << 8 | ToBits(part(kFirstColor + k), 8);
  }
  words[kColor] = words[kColor] << 8 | OpacityByte(model.attribute(splat::kOpacity)[i]);
  std::array<double, 4> q{};
  for (int k = 0; k < 4; ++k)
    q[static_cast<std::size_t>(k)] = static_cast<double>(model.attribute(splat::kQuaternion + k)[i]);
  words[kRotation] = PackRotation(q);
  return words;
}

void Unpack(const std::array<std::uint32_t, kNumWords>& words, const Bounds& bounds, Index i, SplatModel* model) {
  for (std::size_t b = 0; b < kBounded; ++b) {
    const std::size_t k = b % 3;
    double part = 0;
    if (b < kFirstColor) {
      part = FromBits(words[b < 3 ? kPosition : kScale] >> kThreeShifts[k], kThreeBits[k]);
    } else {
      part = FromBits(words[kColor] >> (24 - 8 * k), 8);
    }
    const double value = bounds.min[b] * (1 - part) + bounds.max[b] * part;
    model->attribute(kAttributes[b])[i] = static_cast<float>(b < kFirstColor ? value : DcOf(value));
  }
  model->attribute(splat::kOpacity)[i] = OpacityLogit(static_cast<std::uint8_t>(words[kColor] & 0xff));
  const std::array<double, 4> q = UnpackRotation(words[kRotation]);
  for (int k = 0; k < 4; ++k)
    model->attribute(splat::kQuaternion + k)[i] = static_cast<float>(q[static_cast<std::size_t>(k)]);
}

// The harmonics of Gaussians [begin, end). Half of the rounding error is added to the same coefficient of the next
// Gaussian, a neighbour: errors cancel in pixels that show both. An error is then at most 3/4 of a step.
void WriteSh(const SplatModel& model, Index begin, Index end, std::uint8_t* bytes) {
  constexpr double kHalfStep = 1.0 / 64;
  std::array<double, splat::kMaxAttributes> carried{};
  for (Index i = begin; i < end; ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      for (int attribute = splat::kSh + 3 + channel; attribute < model.num_attributes(); attribute += 3) {
        double& error = carried[static_cast<std::size_t>(attribute)];
        const double value = static_cast<double>(model.attribute(attribute)[i]) + error;
        *bytes = ByteOfSh(value);
        error = 0.5 * std::clamp(value - ShOfByte(*bytes++), -kHalfStep, kHalfStep);
      }
    }
  }
}

using Iterator = std::vector<Index>::iterator;

// A cut separates at least 1/kSmallestPart of the chunks: limits the recursion.
constexpr Index kSmallestPart = 16;

struct Box {
  std::array<double, 3> min, max;

  Box() {
    min.fill(std::numeric_limits<double>::infinity());
    max.fill(-std::numeric_limits<double>::infinity());
  }
  void Add(const SplatModel& model, Index i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto mean = static_cast<double>(model.attribute(splat::kMean + static_cast<int>(k))[i]);
      min[k] = std::min(min[k], mean);
      max[k] = std::max(max[k], mean);
    }
  }
  double SumOfSquares() const {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (max[k] - min[k]) * (max[k] - min[k]);
    return sum;
  }
};

struct Cut {
  double cost = std::numeric_limits<double>::infinity();
  Index first_part = 0;  // number of Gaussians
};

// The best cut after a multiple of `chunk` Gaussians in this order.
Cut BestCut(const SplatModel& model, const std::vector<Index>& order, Index chunk) {
  const auto n = static_cast<Index>(order.size());
  const Index chunks = (n - 1) / chunk + 1, least = std::max<Index>(1, chunks / kSmallestPart);
  std::vector<double> costs(static_cast<std::size_t>(chunks));  // cost of the part before chunk c
  Box before, after;
  for (Index i = 0; i < n; ++i) {
    if (i > 0 && i % chunk == 0)
      costs[static_cast<std::size_t>(i / chunk)] = static_cast<double>(i) * before.SumOfSquares();
    before.Add(model, order[static_cast<std::size_t>(i)]);
  }
  Cut best;
  for (Index i = n - 1; i > 0; --i) {
    after.Add(model, order[static_cast<std::size_t>(i)]);
    const Index c = i / chunk;
    if (i % chunk != 0 || c < least || chunks - c < least) continue;
    const double cost = costs[static_cast<std::size_t>(c)] + static_cast<double>(n - i) * after.SumOfSquares();
    if (cost < best.cost) best = {cost, i};
  }
  return best;
}

void Part(const SplatModel& model, Index chunk, Iterator begin, Iterator end) {
  if (end - begin <= chunk) return;
  std::array<std::vector<Index>, 3> orders;
  std::array<Cut, 3> cuts;
  ParallelFor(3, 1, [&](Index axis) {
    const float* mean = model.attribute(splat::kMean + static_cast<int>(axis));
    auto& order = orders[static_cast<std::size_t>(axis)];
    order.assign(begin, end);
    std::sort(order.begin(), order.end(),
              [mean](Index i, Index j) { return std::pair(mean[i], i) < std::pair(mean[j], j); });
    cuts[static_cast<std::size_t>(axis)] = BestCut(model, order, chunk);
  });
  const auto best =
      std::min_element(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.cost < b.cost; });
  const auto& order = orders[static_cast<std::size_t>(best - cuts.begin())];
  std::copy(order.begin(), order.end(), begin);
  const Iterator middle = begin + best->first_part;
  ParallelFor(2, 1,
              [&](Index part) { part == 0 ? Part(model, chunk, begin, middle) : Part(model, chunk, middle, end); });
}

}  // namespace

bool IsCompressedPly(const PlyFile& file) { return file.Has("chunk"); }

SplatModel ReadCompressedPly(const PlyFile& file, std::vector<std::string>* notes) {
  const PlyTable chunks(file, "chunk"), vertices(file, "vertex");
  const Index count = vertices.count();
  if (count == 0) Fail(kBadFile, "{}: it holds no Gaussians", file.path());
  if (chunks.count() != (count - 1) / kChunk + 1) {
    Fail(kBadFile,
         "{}: {} chunks for {} Gaussians, instead of one for every {}; the file is damaged, copy or export it again",
         file.path(), chunks.count(), count, kChunk);
  }
  SplatModel model;
  if (file.Has("sh")) {
    const PlyTable sh(file, "sh");
    if (sh.count() != count) {
      Fail(kBadFile,
           "{}: SH coefficients for {} Gaussians, but the file has {}; the file is damaged, copy or export it again",
           file.path(), sh.count(), count);
    }
    model.Resize(DegreeOf(file, sh), count);
    ReadSh(file, sh, &model);
  } else {
    model.Resize(0, count);
  }
  ReadSplatComments(file.path(), file.comments(), &model);
  const std::vector<Bounds> bounds = ReadBounds(file, chunks);
  std::array<std::vector<double>, kNumWords> columns;
  for (std::size_t w = 0; w < kNumWords; ++w) columns[w] = ReadWhole(file, vertices, kWords[w], PlyType::kUint32);
  ParallelForChunks(count, kChunk, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      std::array<std::uint32_t, kNumWords> words;
      for (std::size_t w = 0; w < kNumWords; ++w) {
        words[w] = static_cast<std::uint32_t>(columns[w][static_cast<std::size_t>(i)]);
      }
      Unpack(words, bounds[static_cast<std::size_t>(i / kChunk)], i, &model);
    }
  });
  RemoveUnusableGaussians(file.path(), notes, &model);
  return model;
}

void WriteCompressedPly(const std::string& path, const SplatModel& in_any_order) {
  CheckDrawable(path, in_any_order);
  if (in_any_order.count == 0) Fail(kBadArgument, "{}: cannot write a splat without Gaussians", path);
  const SplatModel model = InOrder(AtOneDegree(in_any_order), ChunkOrder(in_any_order, kChunk));
  const Index count = model.count, chunks = (count - 1) / kChunk + 1;
  const int rest = ShCoefficients(model.sh_degree) - 1;

  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : PlyComments(model)) header += fmt::format("comment {}\n", comment);
  header += fmt::format("element chunk {}\n", chunks);
  for (const BoundName& bound : kBounds) header += fmt::format("property float {}\n", bound.name);
  header += fmt::format("element vertex {}\n", count);
  for (const char* word : kWords) header += fmt::format("property uint {}\n", word);
  if (rest > 0) header += fmt::format("element sh {}\n", count);
  for (int i = 0; i < 3 * rest; ++i) header += fmt::format("property uchar f_rest_{}\n", i);
  header += "end_header\n";

  std::vector<float> bounds(static_cast<std::size_t>(chunks) * std::size(kBounds));
  std::vector<std::array<std::uint32_t, kNumWords>> words(static_cast<std::size_t>(count));
  std::vector<std::uint8_t> sh(static_cast<std::size_t>(count * 3 * rest));
  ParallelForChunks(count, kChunk, [&](Index begin, Index end) {
    const Bounds own = BoundsOf(model, begin, end);
    float* out = bounds.data() + begin / kChunk * static_cast<Index>(std::size(kBounds));
    for (const auto& [name, bounded, is_max] : kBounds)
      *out++ = static_cast<float>((is_max ? own.max : own.min)[bounded]);
    WriteSh(model, begin, end, sh.data() + begin * 3 * rest);
    for (Index i = begin; i < end; ++i) words[static_cast<std::size_t>(i)] = Pack(model, own, i);
  });
  AtomicFile file(path);
  file.Write(header);
  file.Write({reinterpret_cast<const char*>(bounds.data()), bounds.size() * sizeof(float)});
  file.Write({reinterpret_cast<const char*>(words.data()), words.size() * sizeof(words[0])});
  file.Write({reinterpret_cast<const char*>(sh.data()), sh.size()});
  file.Commit();
}

std::vector<Index> ChunkOrder(const SplatModel& model, Index chunk) {
  std::vector<Index> order(static_cast<std::size_t>(model.count));
  std::iota(order.begin(), order.end(), Index{0});
  Part(model, chunk, order.begin(), order.end());
  return order;
}

}  // namespace vesta::gs
