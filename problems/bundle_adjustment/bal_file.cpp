// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bal_file.h"

#include <fmt/compile.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bundle {
namespace {

// Reads numbers one after the other and counts lines.
class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)), text_(ReadFile(path_)) {
    next_ = text_.data();
    end_ = next_ + text_.size();
    // These files are usually distributed compressed.
    for (const std::string_view packed : {"BZh", "\37\213", "PK\3\4", "\3757zXZ"}) {
      if (text_.starts_with(packed))
        Fail(kUnsupported, "{}: compressed; unpack it first (bunzip2, gunzip, unzip, unxz)", path_);
    }
  }

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
  Index bytes() const { return static_cast<Index>(text_.size()); }
  Index line() const { return line_; }
  const std::string& path() const { return path_; }

 private:
  static bool IsSpace(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  void SkipSpace() {
    for (; next_ != end_ && IsSpace(*next_); ++next_) line_ += *next_ == '\n' ? 1 : 0;
  }
  [[noreturn]] void Refuse(const char* what, const char* rule) const {
    std::string_view rest(next_, static_cast<std::size_t>(end_ - next_));
    Fail(kBadFile, "{}: line {}: found '{}' instead of {}; {}", path_, line_, Printable(NextWord(&rest)), what, rule);
  }

  std::string path_, text_;
  const char *next_ = nullptr, *end_ = nullptr, *word_ = nullptr;
  Index line_ = 1;
};

Index ReadCount(Reader& in, const char* what) {
  const auto count = in.Read<Index>(what);
  if (count < 0 || count > std::numeric_limits<std::int32_t>::max()) {
    Fail(kBadFile, "{}: line {}: {} is {}; it must be 0 to {}", in.path(), in.line(), what, count,
         std::numeric_limits<std::int32_t>::max());
  }
  return count;
}

}  // namespace

BundleData ReadBal(const std::string& path) {
  Reader in(path);
  BundleData data;
  data.num_cameras = ReadCount(in, "the number of cameras");
  data.num_points = ReadCount(in, "the number of points");
  const Index observations = ReadCount(in, "the number of observations");
  const Index parameters = kCameraSize * data.num_cameras + kPointSize * data.num_points;
  // Every number takes at least one digit and one space. Checked before any allocation that depends on the counts.
  if (4 * observations + parameters > (in.bytes() + 1) / 2) {
    Fail(kBadFile,
         "{}: line {}: {} cameras, {} points and {} observations do not fit into {} bytes; the file is truncated or "
         "is not a BAL file",
         path, in.line(), data.num_cameras, data.num_points, observations, in.bytes());
  }
  data.observations.resize(static_cast<std::size_t>(observations));
  for (Observation& o : data.observations) {
    o.camera = in.ReadIndex(data.num_cameras, "the camera of an observation");
    o.point = in.ReadIndex(data.num_points, "the point of an observation");
    for (double& value : o.pixel) value = in.Read<double>("a pixel coordinate");
  }
  data.x.resize(static_cast<std::size_t>(parameters));
  for (double& value : data.x) value = in.Read<double>("a parameter");
  in.ExpectEnd();
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
