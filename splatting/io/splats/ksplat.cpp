// SPDX-License-Identifier: Apache-2.0
// Layout: SplatBuffer.js of github.com/mkkellogg/GaussianSplats3D.
#include "splatting/io/splats/ksplat.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "kernels/core/check.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {
namespace {

constexpr int kMaxKsplatDegree = 2;
constexpr Index kKsplatHeaderBytes = 4096, kSectionHeaderBytes = 1024, kBucketBytes = 3 * sizeof(float);
constexpr double kUsualMiddle = 32767;  // the 16-bit mean of the bucket's centre
constexpr float kUsualShLimit = 1.5f;

// The value at an offset of a header or a row, which must contain it.
template <class T>
T At(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

// Of the whole file.
struct KsplatHeader {
  Index sections, count;
  int level;
  double min_sh, max_sh;  // of a byte; level 2
};

// A section of Gaussians in buckets: first the full buckets, then the others. A mean is relative to the centre of its
// bucket. Level 0 has no buckets.
struct KsplatSection {
  Index count, bucket_size, full_buckets, other_buckets;
  double step, middle;  // the units of a mean; its value at the centre
  int sh_degree;
  std::string_view other_sizes, centers, rows;  // bytes
};

// Bytes of a number, and offsets in a row. Means and sizes have three numbers, quaternions four, colours four bytes.
struct KsplatRow {
  std::size_t number, sh_number;

  explicit KsplatRow(int level) : number(level == 0 ? 4 : 2), sh_number(level == 2 ? 1 : number) {}
  std::size_t scale() const { return 3 * number; }
  std::size_t quaternion() const { return 6 * number; }
  std::size_t color() const { return 10 * number; }
  std::size_t sh() const { return color() + 4; }
  Index Width(int sh_degree) const {
    return static_cast<Index>(sh() + sh_number * static_cast<std::size_t>(splat::NumHigherHarmonics(sh_degree)));
  }
  // The k-th number from `offset` on, counted from zero.
  float Number(std::string_view row, std::size_t offset, int k) const {
    const std::size_t at = offset + number * static_cast<std::size_t>(k);
    return number == 4 ? At<float>(row, at) : FromHalfBits(At<std::uint16_t>(row, at));
  }
};

KsplatHeader ReadKsplatHeader(const std::string& path, ByteReader* file) {
  const std::string_view bytes = file->ReadBytes(1, kKsplatHeaderBytes, "the header");
  const int major = At<std::uint8_t>(bytes, 0), minor = At<std::uint8_t>(bytes, 1);
  if (major != 0 || minor != 1) {
    Fail(kUnsupported, "{}: .ksplat version {}.{} is not supported, only 0.1; export it again, or as .ply", path, major,
         minor);
  }
  KsplatHeader header{};
  header.sections = At<std::uint32_t>(bytes, 4);
  header.count = At<std::uint32_t>(bytes, 16);
  header.level = At<std::uint16_t>(bytes, 20);
  if (header.level > 2) {
    Fail(kUnsupported, "{}: compression level {} is not supported, only 0 to 2; export it again, or as .ply", path,
         header.level);
  }
  if (header.count == 0) Fail(kBadFile, "{}: it holds no Gaussians", path);
  const auto min_sh = At<float>(bytes, 36), max_sh = At<float>(bytes, 40);
  header.min_sh = static_cast<double>(min_sh == 0 ? -kUsualShLimit : min_sh);
  header.max_sh = static_cast<double>(max_sh == 0 ? kUsualShLimit : max_sh);
  return header;
}

// header: of the section. The file must be at the data of the section.
KsplatSection ReadKsplatSection(const std::string& path, const KsplatHeader& whole, std::string_view header,
                                ByteReader* file) {
  KsplatSection section{};
  section.count = At<std::uint32_t>(header, 0);
  const Index capacity = At<std::uint32_t>(header, 4), buckets = At<std::uint32_t>(header, 12);
  section.bucket_size = At<std::uint32_t>(header, 8);
  const auto middle = At<std::uint32_t>(header, 24);
  section.middle = middle == 0 ? kUsualMiddle : middle;
  section.step = static_cast<double>(At<float>(header, 16)) / 2 / section.middle;
  const Index bucket_bytes = At<std::uint16_t>(header, 20);
  section.full_buckets = At<std::uint32_t>(header, 32);
  section.other_buckets = At<std::uint32_t>(header, 36);
  section.sh_degree = At<std::uint16_t>(header, 40);
  if (section.sh_degree > kMaxKsplatDegree) {
    Fail(kBadFile, "{}: SH degree {} is not supported; the maximum is {}", path, section.sh_degree, kMaxKsplatDegree);
  }
  if (section.count > capacity || section.full_buckets + section.other_buckets > buckets ||
      (buckets > 0 && bucket_bytes != kBucketBytes)) {
    Fail(kBadFile, "{}: the counts of a section contradict each other; the file is damaged, copy or export it again",
         path);
  }
  const Index width = KsplatRow(whole.level).Width(section.sh_degree);
  section.other_sizes = file->ReadBytes(section.other_buckets, sizeof(std::uint32_t), "the bucket sizes");
  section.centers = file->ReadBytes(buckets, kBucketBytes, "the bucket centres");
  section.rows = file->ReadBytes(capacity, width, "the Gaussians of a section");
  section.rows = section.rows.substr(0, static_cast<std::size_t>(section.count * width));
  return section;
}

// SH values in a row: all red ones of a band, then green, then blue; then the next band.
int ShAttribute(int index) {
  const int band = index < splat::NumHigherHarmonics(1) ? 1 : 2;
  const int first = splat::NumHigherHarmonics(band - 1), width = 2 * band + 1;
  const int channel = (index - first) / width, coefficient = (index - first) % width;
  return splat::FirstOfBand(band) + 3 * coefficient + channel;
}

// center: of the bucket.
void UnpackRow(const KsplatHeader& header, const KsplatSection& section, const std::array<double, 3>& center,
               std::string_view row, Index i, SplatModel* model) {
  const KsplatRow layout(header.level);
  const auto set = [&](int attribute, double value) { model->attribute(attribute)[i] = static_cast<float>(value); };
  const auto number = [&](std::size_t offset, int k) { return static_cast<double>(layout.Number(row, offset, k)); };
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    set(splat::kMean + k, header.level == 0
                              ? number(0, k)
                              : (At<std::uint16_t>(row, 2 * axis) - section.middle) * section.step + center[axis]);
    model->attribute(splat::kLogScale + k)[i] = LogScaleOf(layout.Number(row, layout.scale(), k));
    set(splat::kSh + k, DcOf(At<std::uint8_t>(row, layout.color() + axis) / 255.0));
  }
  for (int k = 0; k < 4; ++k) set(splat::kQuaternion + k, number(layout.quaternion(), k));
  model->attribute(splat::kOpacity)[i] = OpacityLogit(At<std::uint8_t>(row, layout.color() + 3));
  for (int k = 0; k < splat::NumHigherHarmonics(section.sh_degree); ++k) {
    const auto byte = [&] { return At<std::uint8_t>(row, layout.sh() + static_cast<std::size_t>(k)) / 255.0; };
    set(ShAttribute(k),
        header.level < 2 ? number(layout.sh(), k) : header.min_sh + (header.max_sh - header.min_sh) * byte());
  }
}

// first: index in the model of the section's first Gaussian.
void UnpackSection(const std::string& path, const KsplatHeader& header, const KsplatSection& section, Index first,
                   SplatModel* model) {
  const Index width = KsplatRow(header.level).Width(section.sh_degree);
  Index done = 0;
  const auto unpack = [&](Index most, const std::array<double, 3>& center) {
    for (const Index end = std::min(section.count, done + most); done < end; ++done) {
      const auto at = static_cast<std::size_t>(done * width);
      UnpackRow(header, section, center, section.rows.substr(at), first + done, model);
    }
  };
  if (header.level == 0) unpack(section.count, {});
  for (Index bucket = 0; bucket < section.full_buckets + section.other_buckets && done < section.count; ++bucket) {
    std::array<double, 3> center{};
    for (std::size_t k = 0; k < 3; ++k) {
      center[k] =
          static_cast<double>(At<float>(section.centers, static_cast<std::size_t>(bucket * kBucketBytes) + 4 * k));
    }
    const Index other = bucket - section.full_buckets;
    unpack(other < 0 ? section.bucket_size
                     : At<std::uint32_t>(section.other_sizes, static_cast<std::size_t>(other) * sizeof(std::uint32_t)),
           center);
  }
  if (done < section.count) {
    Fail(kBadFile,
         "{}: the buckets of a section have {} of its {} Gaussians; the file is damaged, copy or export it again", path,
         done, section.count);
  }
}

}  // namespace

SplatModel ReadKsplat(const std::string& path, std::string bytes, std::vector<std::string>* notes) {
  ByteReader file(path, std::move(bytes));
  const KsplatHeader header = ReadKsplatHeader(path, &file);
  std::string_view headers = file.ReadBytes(header.sections, kSectionHeaderBytes, "the section headers");
  std::vector<KsplatSection> sections;
  sections.reserve(static_cast<std::size_t>(header.sections));
  Index count = 0;
  int sh_degree = 0;
  for (; !headers.empty(); headers.remove_prefix(kSectionHeaderBytes)) {
    const KsplatSection& section = sections.emplace_back(ReadKsplatSection(path, header, headers, &file));
    count += section.count;
    if (section.count > 0) sh_degree = std::max(sh_degree, section.sh_degree);
  }
  if (count != header.count) {
    Fail(kBadFile,
         "{}: the sections have {} Gaussians, but the header counts {}; the file is damaged, copy or export it "
         "again",
         path, count, header.count);
  }
  SplatModel model;
  model.Resize(sh_degree, count);
  Index first = 0;
  for (const KsplatSection& section : sections) {
    UnpackSection(path, header, section, first, &model);
    first += section.count;
  }
  RemoveUnusableGaussians(path, notes, &model);
  return AtStoredDegrees(std::move(model));
}

}  // namespace vesta::gs
