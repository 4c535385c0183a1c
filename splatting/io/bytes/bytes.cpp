// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/bytes.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <new>
#include <utility>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

// Added to zlib's window size, it selects a gzip header.
constexpr int kWithGzipHeader = 16;
constexpr std::size_t kMostComment = 1000;

// zlib has 32-bit sizes and non-const pointers.
uInt Counted(std::size_t size) { return static_cast<uInt>(std::min<std::size_t>(size, 1u << 30)); }
Bytef* Writable(const char* bytes) { return reinterpret_cast<Bytef*>(const_cast<char*>(bytes)); }

}  // namespace

static_assert(std::endian::native == std::endian::little, "the binary formats here are little-endian");

ByteReader::ByteReader(std::string path) : path_(std::move(path)), bytes_(ReadFile(path_)) {}

ByteReader::ByteReader(std::string path, std::string bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {}

std::string ByteReader::Where() const { return fmt::format("{}: byte {}", path_, item_); }

void ByteReader::FailTruncated(const char* what) const {
  Fail(kBadFile, "{}: the file of {} bytes ends within {}; it is truncated or damaged, copy or export it again",
       Where(), bytes_.size(), what);
}

const char* ByteReader::Take(Index count, Index bytes_each, const char* what) {
  item_ = position_;
  const Index left = static_cast<Index>(bytes_.size()) - position_;
  if (count < 0 || count > left / bytes_each) FailTruncated(what);
  position_ += count * bytes_each;
  return bytes_.data() + item_;
}

std::string ByteReader::ReadText(const char* what) {
  item_ = position_;
  const std::size_t end = bytes_.find('\0', static_cast<std::size_t>(position_));
  if (end == std::string::npos) FailTruncated(what);
  position_ = static_cast<Index>(end) + 1;
  return bytes_.substr(static_cast<std::size_t>(item_), end - static_cast<std::size_t>(item_));
}

Index ByteReader::ReadCount(Index bytes_each, const char* what) {
  const auto count = Read<std::uint64_t>(what);
  const Index left = static_cast<Index>(bytes_.size()) - position_;
  if (count > static_cast<std::uint64_t>(left / bytes_each)) {
    Fail(
        kBadFile,
        "{}: {} is {}, but the remaining {} bytes hold {} at most; the file is truncated or damaged, copy or export it "
        "again",
        Where(), what, count, left, left / bytes_each);
  }
  return static_cast<Index>(count);
}

void ByteReader::ExpectEnd() const {
  if (position_ != static_cast<Index>(bytes_.size())) {
    Fail(kBadFile, "{}: byte {}: {} bytes follow the last record; the file is damaged, copy or export it again", path_,
         position_, static_cast<Index>(bytes_.size()) - position_);
  }
}

struct GzipReader::State {
  z_stream stream{};
  gz_header header{};
  std::array<char, kMostComment + 1> comment{};  // always ends with a zero
  bool has_ended = false;
};

GzipReader::GzipReader(std::string path, std::string_view bytes)
    : path_(std::move(path)), rest_(bytes), state_(std::make_unique<State>()) {
  if (inflateInit2(&state_->stream, MAX_WBITS + kWithGzipHeader) != Z_OK) throw std::bad_alloc();
  state_->header.comment = reinterpret_cast<Bytef*>(state_->comment.data());
  state_->header.comm_max = kMostComment;
  inflateGetHeader(&state_->stream, &state_->header);
}

GzipReader::~GzipReader() { inflateEnd(&state_->stream); }

std::size_t GzipReader::Read(char* out, std::size_t size) {
  z_stream& stream = state_->stream;
  std::size_t read = 0;
  while (read < size && !state_->has_ended) {
    stream.next_in = Writable(rest_.data());
    stream.avail_in = Counted(rest_.size());
    stream.next_out = Writable(out + read);
    stream.avail_out = Counted(size - read);
    const uInt given = stream.avail_in, room = stream.avail_out;
    const int result = inflate(&stream, Z_NO_FLUSH);
    rest_.remove_prefix(given - stream.avail_in);
    read += room - stream.avail_out;
    state_->has_ended = result == Z_STREAM_END;
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    const bool is_stuck = result == Z_BUF_ERROR || (given == 0 && room == stream.avail_out);
    if (!state_->has_ended && (is_stuck || result != Z_OK)) {
      Fail(kBadFile, "{}: its gzip stream is truncated or damaged; copy or export it again", path_);
    }
  }
  return read;
}

std::string GzipReader::comment() const { return state_->comment.data(); }

std::string Gzip(std::string_view bytes, const std::string& comment) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + kWithGzipHeader, 9, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::bad_alloc();
  }
  gz_header header{};
  header.os = 255;  // unknown, so that the bytes are the same everywhere
  header.comment = comment.empty() ? nullptr : Writable(comment.c_str());
  deflateSetHeader(&stream, &header);
  std::string result;
  std::array<char, 1 << 16> block;
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    stream.next_in = Writable(bytes.data());
    stream.avail_in = Counted(bytes.size());
    stream.next_out = Writable(block.data());
    stream.avail_out = Counted(block.size());
    const uInt given = stream.avail_in;
    // With input and output space left, deflate makes progress.
    state = deflate(&stream, given == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    bytes.remove_prefix(given - stream.avail_in);
    result.append(block.data(), block.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  return result;
}

}  // namespace vesta::gs
