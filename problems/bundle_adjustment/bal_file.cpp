// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bal_file.h"

#include <fmt/compile.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <exception>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bundle {
namespace {

// Without branches, for SIMD loops.
bool IsSpace(char c) { return (c == ' ') | (c == '\n') | (c == '\r') | (c == '\t'); }

// Reads the numbers of a text one after the other and counts lines.
class Reader {
 public:
  // line: of the first character.
  Reader(const std::string& path, std::string_view text, Index line)
      : path_(path), next_(text.data()), end_(next_ + text.size()), line_(line) {}

  template <class T>
  T Read(const char* what) {
    SkipSpace();
    if (next_ == end_) {
      Fail(kBadFile, "{}: line {}: the file ends where {} should follow; it is truncated, copy it again", path_, line_,
           what);
    }
    T value{};
    const auto [after, error] = std::from_chars(next_ + (*next_ == '+' ? 1 : 0), end_, value);
    if (error != std::errc() || (after != end_ && !IsSpace(*after))) {
      Refuse(what, "it must be a number that fits its type");
    }
    if constexpr (std::is_same_v<T, double>) {
      if (!std::isfinite(value)) Refuse(what, "it must be finite");
    }
    word_ = next_;
    next_ = after;
    return value;
  }
  // Reads a whole number in [0, limit).
  std::int32_t ReadIndex(Index limit, const char* what) {
    const auto value = Read<Index>(what);
    if (value < 0 || value >= limit) {
      next_ = word_;
      Refuse(what, fmt::format("it must be 0 to {}", limit - 1).c_str());
    }
    return static_cast<std::int32_t>(value);
  }
  void ExpectEnd() {
    SkipSpace();
    if (next_ != end_) Refuse("the end of the file", "nothing may follow the last parameter");
  }
  std::string_view rest() const { return {next_, static_cast<std::size_t>(end_ - next_)}; }
  Index line() const { return line_; }
  const std::string& path() const { return path_; }

 private:
  void SkipSpace() {
    for (; next_ != end_ && IsSpace(*next_); ++next_) line_ += *next_ == '\n' ? 1 : 0;
  }
  [[noreturn]] void Refuse(const char* what, const char* rule) const {
    std::string_view found = rest();
    Fail(kBadFile, "{}: line {}: found '{}' instead of {}; {}", path_, line_, Printable(NextWord(&found)), what, rule);
  }

  const std::string& path_;
  const char *next_, *end_, *word_ = nullptr;
  Index line_;
};

Index ReadCount(Reader& in, const char* what) {
  const auto count = in.Read<Index>(what);
  if (count < 0 || count > std::numeric_limits<std::int32_t>::max()) {
    Fail(kBadFile, "{}: line {}: {} is {}; it must be 0 to {}", in.path(), in.line(), what, count,
         std::numeric_limits<std::int32_t>::max());
  }
  return count;
}

// Reads the number with index k (from 0, after the counts) to its place. Throws Error if the data have no such number.
void ReadNumber(Reader& in, Index k, BundleData* data) {
  const Index of_observations = 4 * std::ssize(data->observations), parameter = k - of_observations;
  if (parameter >= std::ssize(data->x)) return in.ExpectEnd();
  if (parameter >= 0) {
    data->x[static_cast<std::size_t>(parameter)] = in.Read<double>("a parameter");
    return;
  }
  Observation& o = data->observations[static_cast<std::size_t>(k / 4)];
  switch (k % 4) {
    case 0:
      o.camera = in.ReadIndex(data->num_cameras, "the camera of an observation");
      break;
    case 1:
      o.point = in.ReadIndex(data->num_points, "the point of an observation");
      break;
    default:
      o.pixel[k % 4 - 2] = in.Read<double>("a pixel coordinate");
  }
}

// A part of the text.
struct Part {
  std::string_view text;             // empty, or begins with a space
  Index first_number = 0, line = 0;  // at its beginning; before the sums in Divide, its own counts
};

void CountNumbersAndLines(Part* part) {
  const std::string_view text = part->text;
  constexpr std::size_t kBlock = 255;  // so that counts of a block fit into bytes
  for (std::size_t begin = 0; begin < text.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, text.size());
    std::uint8_t numbers = 0, lines = 0;
    for (std::size_t i = std::max<std::size_t>(begin, 1); i < end; ++i) {
      numbers = static_cast<std::uint8_t>(numbers + (IsSpace(text[i - 1]) & !IsSpace(text[i])));
    }
    for (std::size_t i = begin; i < end; ++i) lines = static_cast<std::uint8_t>(lines + (text[i] == '\n'));
    part->first_number += numbers, part->line += lines;
  }
}

// Divides the text into parts, for threads. The last part is empty, at the end of the text. line: of its beginning.
std::vector<Part> Divide(std::string_view text, Index line) {
  constexpr std::size_t kPartBytes = 1 << 20;
  std::vector<Part> parts;
  while (!text.empty()) {
    std::size_t size = std::min(kPartBytes, text.size());
    while (size < text.size() && !IsSpace(text[size])) ++size;
    parts.push_back({text.substr(0, size)});
    text.remove_prefix(size);
  }
  ParallelFor(std::ssize(parts), 1, [&](Index k) { CountNumbersAndLines(&parts[static_cast<std::size_t>(k)]); });
  Index number = 0;
  for (Part& part : parts) {
    number += std::exchange(part.first_number, number);
    line += std::exchange(part.line, line);
  }
  parts.push_back({text, number, line});
  return parts;
}

// Reads the numbers after the counts, in parallel. Throws the first error in the file.
void ReadNumbers(const std::string& path, std::string_view text, Index line, BundleData* data) {
  const std::vector<Part> parts = Divide(text, line);
  std::vector<std::exception_ptr> errors(parts.size());
  ParallelFor(std::ssize(parts) - 1, 1, [&](Index i) {
    const auto k = static_cast<std::size_t>(i);
    Reader in(path, parts[k].text, parts[k].line);
    try {
      for (Index n = parts[k].first_number; n < parts[k + 1].first_number; ++n) ReadNumber(in, n, data);
    } catch (...) {
      errors[k] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  Reader end(path, parts.back().text, parts.back().line);
  ReadNumber(end, parts.back().first_number, data);
}

}  // namespace

BundleData ReadBal(const std::string& path) {
  const HostBuffer<char> bytes = ReadLargeFile(path);
  const std::string_view text(bytes.data(), static_cast<std::size_t>(bytes.size()));
  // These files are usually distributed compressed.
  for (const std::string_view packed : {"BZh", "\37\213", "PK\3\4", "\3757zXZ"}) {
    if (text.starts_with(packed))
      Fail(kUnsupported, "{}: compressed; unpack it first (bunzip2, gunzip, unzip, unxz)", path);
  }
  Reader in(path, text, 1);
  BundleData data;
  data.num_cameras = ReadCount(in, "the number of cameras");
  data.num_points = ReadCount(in, "the number of points");
  const Index observations = ReadCount(in, "the number of observations");
  const Index parameters = kCameraSize * data.num_cameras + kPointSize * data.num_points;
  // Every number takes at least one digit and one space. Checked before any allocation that depends on the counts.
  if (4 * observations + parameters > (std::ssize(text) + 1) / 2) {
    Fail(kBadFile,
         "{}: line {}: {} cameras, {} points and {} observations do not fit into {} bytes; the file is truncated or "
         "is not a BAL file",
         path, in.line(), data.num_cameras, data.num_points, observations, std::ssize(text));
  }
  data.observations.resize(static_cast<std::size_t>(observations));
  data.x.resize(static_cast<std::size_t>(parameters));
  ReadNumbers(path, in.rest(), in.line(), &data);
  return data;
}

void WriteBal(const std::string& path, const BundleData& data) {
  AtomicFile file(path);
  WriteBal(file, data);
  file.Commit();
}

void WriteBal(AtomicFile& file, const BundleData& data) {
  std::string text;
  constexpr std::size_t kPiece = 1 << 20;
  const auto flush = [&](std::size_t limit) {
    if (text.size() < limit) return;
    file.Write(text);
    text.clear();
  };
  const auto out = std::back_inserter(text);
  fmt::format_to(out, FMT_COMPILE("{} {} {}\n"), data.num_cameras, data.num_points, data.observations.size());
  for (const Observation& o : data.observations) {
    fmt::format_to(out, FMT_COMPILE("{} {} {} {}\n"), o.camera, o.point, o.pixel[0], o.pixel[1]);
    flush(kPiece);
  }
  for (const double value : data.x) {
    fmt::format_to(out, FMT_COMPILE("{}\n"), value);
    flush(kPiece);
  }
  flush(1);
}

}  // namespace vesta::bundle
