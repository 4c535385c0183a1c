// SPDX-License-Identifier: Apache-2.0
// Layout: github.com/nianticlabs/spz, README.md and extensions/README.md.
#include "splatting/io/splats/spz_file.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/bytes/zstd_stream.h"
#include "splatting/io/splats/spz_rotation.h"

namespace vesta::gs {
namespace {

constexpr std::uint32_t kSpzMagic = 0x5053474e;  // "NGSP"
constexpr std::uint8_t kAntialiasedFlag = 1, kHasExtensions = 2;
constexpr int kMostFractionBits = 30;

// Types of extensions: the high 16 bits are the vendor, the low 16 bits its extension. Extension 1 of vendor "VS" has
// vesta's comments, one line each.
constexpr std::uint32_t kCameraLimits = 0xadbe0002, kVestaComments = 0x56530001;
constexpr std::size_t kMostInExtension = 1 << 16;

// The first bytes of all versions.
struct SpzHeader {
  std::uint32_t magic = kSpzMagic, version = 0, count = 0;
  std::uint8_t sh_degree = 0, fraction_bits = 0, flags = 0;
  std::uint8_t num_streams = 0;  // zero before version 4
};
static_assert(sizeof(SpzHeader) == 16);

// They follow the header in version 4.
struct SpzStreamsHeader {
  std::uint32_t sizes_at = 0;  // offset of the sizes in the file; extensions may precede them
  std::array<std::uint32_t, 3> reserved{};
};
static_assert(sizeof(SpzStreamsHeader) == 16);

// The zstd streams follow the sizes of all streams, without gaps.
struct SpzStreamSize {
  std::uint64_t compressed = 0, uncompressed = 0;
};
static_assert(sizeof(SpzStreamSize) == 16);

template <class T>
std::string_view BytesOf(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

[[noreturn]] void FailSpzTruncated(const std::string& path) {
  Fail(kBadFile, "{}: truncated or damaged; copy or export it again", path);
}

[[noreturn]] void FailTooLong(const std::string& path) {
  Fail(kBadFile, "{}: bytes follow the last Gaussian; the file is damaged, copy or export it again", path);
}

[[noreturn]] void FailCount(const std::string& path, Index count, std::size_t bytes) {
  Fail(kBadFile, "{}: the header counts {} Gaussians, too many for {} bytes; the file is truncated or damaged", path,
       count, bytes);
}

void CheckHeader(const std::string& path, const SpzHeader& header, std::uint32_t oldest, std::uint32_t latest) {
  if (header.version < oldest || header.version > latest) {
    Fail(kUnsupported, "{}: .spz version {} is not supported; export it as version 1 to {}, or as .ply", path,
         header.version, kLatestSpz);
  }
  if (header.sh_degree > kMaxSpzDegree) {
    Fail(kBadFile, "{}: SH degree {} is not supported; the maximum is {}", path, header.sh_degree, kMaxSpzDegree);
  }
  if (header.fraction_bits > kMostFractionBits) {
    Fail(kBadFile, "{}: {} fraction bits in 24-bit positions; the file is damaged, copy or export it again", path,
         header.fraction_bits);
  }
  if (header.count == 0) Fail(kBadFile, "{}: it holds no Gaussians", path);
}

SpzFile FileOf(const SpzHeader& header) {
  SpzFile file;
  file.version = header.version;
  file.count = header.count;
  file.sh_degree = header.sh_degree;
  file.fraction_bits = header.fraction_bits;
  file.antialiased = (header.flags & kAntialiasedFlag) != 0;
  return file;
}

SpzHeader HeaderOf(const SpzFile& file) {
  SpzHeader header;
  header.version = file.version;
  header.count = static_cast<std::uint32_t>(file.count);
  header.sh_degree = static_cast<std::uint8_t>(file.sh_degree);
  header.fraction_bits = static_cast<std::uint8_t>(file.fraction_bits);
  header.flags = file.antialiased ? kAntialiasedFlag : 0;
  return header;
}

std::vector<std::string> LinesOf(std::string_view text) {
  std::vector<std::string> lines;
  std::string_view line;
  while (NextLine(&text, &line)) lines.emplace_back(line);
  return lines;
}

std::string TextOf(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

// Reads vesta's comments. Skips data that other programs append, but rejects extensions that could change the splat's
// meaning. read(out, size) returns the number of bytes, less than `size` at the end.
void ReadExtensions(const std::string& path, const std::function<std::size_t(char* out, std::size_t size)>& read,
                    std::vector<std::string>* comments) {
  std::array<std::uint32_t, 2> head{};  // type, number of bytes
  for (;;) {
    const std::size_t got = read(reinterpret_cast<char*>(head.data()), sizeof(head));
    if (got == 0) return;
    if (got < sizeof(head)) Fail(kBadFile, "{}: an extension is truncated", path);
    if ((head[0] != kCameraLimits && head[0] != kVestaComments) || head[1] > kMostInExtension) {
      Fail(kUnsupported, "{}: unknown extension of type {:#x}; export the file without it", path, head[0]);
    }
    std::string content(head[1], '\0');
    if (read(content.data(), content.size()) < content.size()) Fail(kBadFile, "{}: an extension is truncated", path);
    if (head[0] == kVestaComments) *comments = LinesOf(content);
  }
}

SpzFile ReadArchive(const std::string& path, std::string_view bytes) {
  GzipReader reader(path, bytes);
  SpzHeader header;
  if (reader.Read(reinterpret_cast<char*>(&header), sizeof(header)) < sizeof(header)) FailSpzTruncated(path);
  if (header.magic != kSpzMagic) {
    Fail(kBadFile, "{}: {}", path,
         BytesOf(header).starts_with("ply") ? "a .ply compressed with gzip; unpack it first: gunzip"
                                            : "a gzip file, but not .spz");
  }
  CheckHeader(path, header, 1, 3);
  SpzFile file = FileOf(header);
  Index width = 0;
  for (int array = 0; array < kNumSpzArrays; ++array) width += file.Width(array);
  if (file.count * width / kMostDeflateExpands > static_cast<Index>(bytes.size())) {
    FailCount(path, file.count, bytes.size());
  }
  for (int array = 0; array < kNumSpzArrays; ++array) {
    std::vector<std::uint8_t>& values = file.arrays[static_cast<std::size_t>(array)];
    values.resize(static_cast<std::size_t>(file.count * file.Width(array)));
    if (reader.Read(reinterpret_cast<char*>(values.data()), values.size()) < values.size()) FailSpzTruncated(path);
  }
  file.comments = LinesOf(reader.comment());
  if (header.flags & kHasExtensions) {
    ReadExtensions(
        path, [&](char* out, std::size_t size) { return reader.Read(out, size); }, &file.comments);
  }
  char more = 0;
  if (reader.Read(&more, 1) > 0) FailTooLong(path);
  return file;
}

SpzFile ReadStreams(const std::string& path, std::string_view bytes) {
  SpzHeader header;
  SpzStreamsHeader streams;
  if (bytes.size() < sizeof(header) + sizeof(streams)) FailSpzTruncated(path);
  std::memcpy(&header, bytes.data(), sizeof(header));
  std::memcpy(&streams, bytes.data() + sizeof(header), sizeof(streams));
  CheckHeader(path, header, kLatestSpz, kLatestSpz);
  SpzFile file = FileOf(header);

  const std::size_t num_streams = file.sh_degree == 0 ? kSpzSh : kNumSpzArrays;
  if (header.num_streams != num_streams) {
    Fail(kBadFile, "{}: {} streams instead of {} for SH degree {}; the file is damaged, copy or export it again", path,
         header.num_streams, num_streams, file.sh_degree);
  }
  constexpr std::size_t kExtensionsAt = sizeof(header) + sizeof(streams);
  if (streams.sizes_at < kExtensionsAt || streams.sizes_at > bytes.size() ||
      num_streams * sizeof(SpzStreamSize) > bytes.size() - streams.sizes_at) {
    FailSpzTruncated(path);
  }
  if (header.flags & kHasExtensions) {
    std::string_view rest = bytes.substr(kExtensionsAt, streams.sizes_at - kExtensionsAt);
    const auto read = [&](char* out, std::size_t size) {
      const std::size_t got = rest.copy(out, size);
      rest.remove_prefix(got);
      return got;
    };
    ReadExtensions(path, read, &file.comments);
  }

  std::array<SpzStreamSize, kNumSpzArrays> sizes{};
  std::memcpy(sizes.data(), bytes.data() + streams.sizes_at, num_streams * sizeof(SpzStreamSize));
  bytes.remove_prefix(streams.sizes_at + num_streams * sizeof(SpzStreamSize));
  for (std::size_t k = 0; k < num_streams; ++k) {
    const Index size = file.count * file.Width(static_cast<int>(k));
    if (sizes[k].uncompressed != static_cast<std::uint64_t>(size)) {
      Fail(kBadFile, "{}: stream {} has {} bytes instead of {}; the file is damaged, copy or export it again", path, k,
           sizes[k].uncompressed, size);
    }
    if (sizes[k].compressed > bytes.size()) FailSpzTruncated(path);
    const auto compressed = static_cast<std::size_t>(sizes[k].compressed);
    file.arrays[k] = DecompressZstd(path, bytes.substr(0, compressed), size);
    bytes.remove_prefix(compressed);
  }
  if (!bytes.empty()) FailTooLong(path);
  return file;
}

std::string_view Chars(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string StreamsOf(const SpzFile& file) {
  SpzHeader header = HeaderOf(file);
  const std::string comments = TextOf(file.comments);
  std::string extensions;
  if (!comments.empty()) {
    const std::array<std::uint32_t, 2> head{kVestaComments, static_cast<std::uint32_t>(comments.size())};
    header.flags |= kHasExtensions;
    extensions = std::string(BytesOf(head)) + comments;
  }
  SpzStreamsHeader second;
  second.sizes_at = static_cast<std::uint32_t>(sizeof(header) + sizeof(second) + extensions.size());
  std::string sizes, streams;
  for (const std::vector<std::uint8_t>& array : file.arrays) {
    if (array.empty()) continue;
    const std::string stream = CompressZstd(Chars(array));
    sizes += BytesOf(SpzStreamSize{stream.size(), array.size()});
    streams += stream;
    ++header.num_streams;
  }
  return std::string(BytesOf(header)) + std::string(BytesOf(second)) + extensions + sizes + streams;
}

}  // namespace

Index SpzFile::Width(int array) const {
  switch (array) {
    case kSpzMean:
      return version == 1 ? 6 : 9;
    case kSpzOpacity:
      return 1;
    case kSpzRotation:
      return version >= kSpzSmallestThree ? 4 : 3;
    case kSpzSh:
      return splat::NumHigherHarmonics(sh_degree);
    default:
      return 3;
  }
}

SpzFile ReadSpzFile(const std::string& path, std::string_view bytes) {
  return bytes.starts_with("NGSP") ? ReadStreams(path, bytes) : ReadArchive(path, bytes);
}

std::string SpzFileBytes(const SpzFile& file) {
  VESTA_CHECK(file.version >= 2 && file.version <= kLatestSpz, "{}", file.version);
  if (file.version == kLatestSpz) return StreamsOf(file);
  std::string bytes(BytesOf(HeaderOf(file)));
  for (const std::vector<std::uint8_t>& array : file.arrays) bytes += Chars(array);
  return Gzip(bytes, TextOf(file.comments));
}

}  // namespace vesta::gs
