// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/zstd_stream.h"

#include <zstd.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

// Higher levels take several times as long for files that are hardly smaller.
constexpr int kZstdLevel = 12;
constexpr std::size_t kFirstBlock = 1 << 16;

struct FreeStream {
  void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
};

}  // namespace

std::string CompressZstd(std::string_view bytes) {
  std::string stream(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(stream.data(), stream.size(), bytes.data(), bytes.size(), kZstdLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the only error with enough space for the result
  stream.resize(size);
  return stream;
}

std::vector<std::uint8_t> DecompressZstd(const std::string& path, std::string_view stream, Index size) {
  const std::unique_ptr<ZSTD_DStream, FreeStream> state(ZSTD_createDStream());
  if (state == nullptr) throw std::bad_alloc();
  const auto expected = static_cast<std::size_t>(size);
  std::vector<std::uint8_t> bytes;
  ZSTD_inBuffer in{stream.data(), stream.size(), 0};
  std::size_t written = 0, left = 1;  // left: zero at the end of the frame
  while (left != 0) {
    if (written == bytes.size()) bytes.resize(std::min(expected, std::max(kFirstBlock, 2 * written)));
    ZSTD_outBuffer out{bytes.data(), bytes.size(), written};
    const std::size_t read = in.pos;
    left = ZSTD_decompressStream(state.get(), &out, &in);
    const bool is_stuck = in.pos == read && out.pos == written;
    if (ZSTD_isError(left) != 0 || (is_stuck && left != 0)) break;
    written = out.pos;
  }
  if (left != 0 || written != expected || in.pos != stream.size()) {
    Fail(kBadFile, "{}: a zstd stream is damaged or has the wrong size; copy or export the file again", path);
  }
  return bytes;
}

}  // namespace vesta::gs
