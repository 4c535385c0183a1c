// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/byte_reader.h"

#include <bit>
#include <utility>

#include "kernels/core/check.h"

namespace vesta::gs {

static_assert(std::endian::native == std::endian::little, "the binary formats here are little-endian");

ByteReader::ByteReader(std::string path) : path_(std::move(path)), bytes_(ReadFile(path_)) {}

std::string ByteReader::Where() const { return fmt::format("{}: byte {}", path_, item_); }

void ByteReader::FailTruncated(const char* what) const {
  Fail(kBadFile, "{}: the file of {} bytes ends within {}; it is cut short or damaged, copy or export it again",
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
    Fail(kBadFile,
         "{}: {} is {}, but the {} bytes left hold {} at most; the file is cut short or damaged, copy or export it "
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

}  // namespace vesta::gs
