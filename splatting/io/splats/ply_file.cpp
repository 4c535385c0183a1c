// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/ply_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

constexpr std::size_t kMaxElements = 100, kMaxProperties = 1000;

struct TypeName {
  std::string_view name;
  PlyType type;
  Index size;  // bytes
};
constexpr TypeName kTypes[] = {
    {"float", PlyType::kFloat, 4},    {"float32", PlyType::kFloat, 4}, {"double", PlyType::kDouble, 8},
    {"float64", PlyType::kDouble, 8}, {"uchar", PlyType::kUint8, 1},   {"uint8", PlyType::kUint8, 1},
    {"char", PlyType::kInt8, 1},      {"int8", PlyType::kInt8, 1},     {"ushort", PlyType::kUint16, 2},
    {"uint16", PlyType::kUint16, 2},  {"short", PlyType::kInt16, 2},   {"int16", PlyType::kInt16, 2},
    {"uint", PlyType::kUint32, 4},    {"uint32", PlyType::kUint32, 4}, {"int", PlyType::kInt32, 4},
    {"int32", PlyType::kInt32, 4}};

// Moves the first line of `text` to `line`, without its end. Returns false if no line end is left.
bool TakeLine(std::string_view* text, std::string_view* line) {
  const std::size_t end = text->find('\n');
  if (end == std::string_view::npos) return false;
  *line = text->substr(0, end);
  if (line->ends_with('\r')) line->remove_suffix(1);
  text->remove_prefix(end + 1);
  return true;
}

double Value(const char* bytes, PlyType type) {
  const auto read = [bytes](auto value) {
    std::memcpy(&value, bytes, sizeof(value));
    return static_cast<double>(value);
  };
  switch (type) {
    case PlyType::kInt8:
      return read(std::int8_t{});
    case PlyType::kUint8:
      return read(std::uint8_t{});
    case PlyType::kInt16:
      return read(std::int16_t{});
    case PlyType::kUint16:
      return read(std::uint16_t{});
    case PlyType::kInt32:
      return read(std::int32_t{});
    case PlyType::kUint32:
      return read(std::uint32_t{});
    case PlyType::kDouble:
      return read(double{});
    case PlyType::kFloat:
      break;
  }
  return read(float{});
}

}  // namespace

std::string PlyRows(std::string_view element) {
  return element == "vertex" ? "vertices" : fmt::format("rows of {}", Printable(element));
}

PlyFile::PlyFile(const std::string& path) : PlyFile(path, ReadFile(path)) {}

PlyFile::PlyFile(std::string path, std::string bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {
  std::string_view rest = bytes_, line;
  if (rest.starts_with("\x1f\x8b")) Fail(kUnsupported, "{}: compressed by gzip; unpack it first: gunzip", path_);
  if (!TakeLine(&rest, &line) || line != "ply") Fail(kBadFile, "{}: not a .ply file", path_);
  bool has_format = false;
  while (true) {
    if (!TakeLine(&rest, &line))
      Fail(kBadFile, "{}: the header has no end_header; the file is truncated or damaged, copy or export it again",
           path_);
    std::string_view words = line;
    const std::string_view key = NextWord(&words);
    if (key == "end_header") break;
    if (key == "comment") {
      words.remove_prefix(std::min<std::size_t>(words.starts_with(' ') ? 1 : 0, words.size()));
      comments_.emplace_back(words);
    } else if (key == "format") {
      const std::string_view format = NextWord(&words);
      is_ascii_ = format == "ascii";
      has_format = is_ascii_ || format == "binary_little_endian";
      if (!has_format)
        Fail(kUnsupported, "{}: the format {} is not supported; export as binary_little_endian", path_,
             Printable(format));
    } else if (key == "element") {
      if (elements_.size() == kMaxElements) Fail(kBadFile, "{}: more than {} elements", path_, kMaxElements);
      PlyElement& element = elements_.emplace_back();
      element.name = NextWord(&words);
      if (!ParseNumber(NextWord(&words), &element.count) || element.count < 0) {
        element.fault =
            fmt::format("the number of {} in the header is not a valid whole number", PlyRows(element.name));
      }
    } else if (key == "property" && !elements_.empty()) {
      ReadProperty(words);
    }
  }
  if (!has_format) Fail(kBadFile, "{}: the header has no format line; export the file again", path_);
  values_ = bytes_.size() - rest.size();
}

void PlyFile::ReadProperty(std::string_view words) {
  PlyElement& element = elements_.back();
  if (!element.fault.empty()) return;
  const std::string_view type_name = NextWord(&words), name = NextWord(&words);
  const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [&](const TypeName& candidate) { return candidate.name == type_name; });
  const auto has_name = [&](const PlyProperty& other) { return other.name == name; };
  if (type == std::end(kTypes)) {
    element.fault = fmt::format("unknown property type '{}' in the header", Printable(type_name));
  } else if (name.empty() || std::any_of(element.properties.begin(), element.properties.end(), has_name)) {
    element.fault = "the header has a property without a unique name";
  } else if (element.properties.size() == kMaxProperties) {
    element.fault = fmt::format("more than {} properties in a row", kMaxProperties);
  } else {
    element.properties.push_back({std::string(name), type->type, element.stride});
    element.stride += type->size;
  }
}

bool PlyFile::Has(std::string_view element) const {
  return std::any_of(elements_.begin(), elements_.end(), [&](const PlyElement& e) { return e.name == element; });
}

PlyTable::PlyTable(const PlyFile& file, std::string_view name) : path_(file.path()), holds_doubles_(file.is_ascii()) {
  for (const PlyElement& element : file.elements()) {
    if (!element.fault.empty()) Fail(kBadFile, "{}: {}; export the file again", path_, element.fault);
    if (element.name != name) continue;
    rows_name_ = PlyRows(element.name);
    if (element.properties.empty()) break;
    properties_ = element.properties;
    count_ = element.count;
    file.is_ascii() ? ParseAscii(file, element) : FindBinary(file, element);
    return;
  }
  Fail(kBadFile, "{}: it has no {} with properties", path_, PlyRows(name));
}

// Also checks the size of earlier elements.
void PlyTable::FindBinary(const PlyFile& file, const PlyElement& element) {
  std::string_view left = file.values();
  for (const PlyElement& other : file.elements()) {
    const Index most = static_cast<Index>(left.size()) / std::max<Index>(other.stride, 1);
    if (other.stride > 0 && other.count > most) {
      Fail(kBadFile,
           "{}: the header counts {} {}, but the {} bytes after it hold {} at most; the file is truncated or damaged",
           path_, other.count, PlyRows(other.name), left.size(), most);
    }
    if (&other == &element) break;
    left.remove_prefix(static_cast<std::size_t>(other.count * other.stride));
  }
  stride_ = element.stride;
  first_ = left.data();
}

// Converts the values to a binary table of doubles.
void PlyTable::ParseAscii(const PlyFile& file, const PlyElement& element) {
  std::string_view words = file.values();
  for (const PlyElement& other : file.elements()) {
    const auto width = static_cast<Index>(other.properties.size());
    // Each word but the last takes at least two characters including white space.
    const Index most = (static_cast<Index>(words.size()) + 1) / std::max<Index>(2 * width, 1);
    if (width > 0 && other.count > most) {
      Fail(kBadFile,
           "{}: the header counts {} {}, but the {} bytes after it hold {} at most; the file is truncated or damaged",
           path_, other.count, PlyRows(other.name), words.size(), most);
    }
    if (&other == &element) break;
    for (Index i = 0; i < other.count * width; ++i) NextWord(&words);
  }
  for (PlyProperty& property : properties_) property.offset = std::exchange(stride_, stride_ + Index{sizeof(double)});
  parsed_.resize(static_cast<std::size_t>(count_ * stride_));
  char* out = parsed_.data();
  for (Index i = 0; i < count_; ++i) {
    for (const PlyProperty& property : properties_) {
      double value = 0;
      if (!ParseNumber(NextWord(&words), &value)) {
        Fail(kBadFile,
             "{}: {} of {} {} is missing or not a number; the file is truncated or damaged, copy or export it again",
             path_, Printable(property.name), Printable(element.name), i);
      }
      std::memcpy(out, &value, sizeof(value));
      out += sizeof(value);
    }
  }
  first_ = parsed_.data();
}

const PlyProperty* PlyTable::Find(std::string_view property) const {
  const auto it =
      std::find_if(properties_.begin(), properties_.end(), [&](const PlyProperty& p) { return p.name == property; });
  return it == properties_.end() ? nullptr : &*it;
}

bool PlyTable::Has(std::string_view property, PlyType type) const {
  const PlyProperty* found = Find(property);
  return found != nullptr && found->type == type;
}

int PlyTable::CountWithPrefix(std::string_view prefix) const {
  return static_cast<int>(std::count_if(properties_.begin(), properties_.end(),
                                        [&](const PlyProperty& p) { return p.name.starts_with(prefix); }));
}

float PlyTable::FullScale(std::string_view property) const {
  return Has(property, PlyType::kUint8) ? 255.0f : Has(property, PlyType::kUint16) ? 65535.0f : 1.0f;
}

template <class T>
void PlyTable::Copy(const std::vector<Column<T>>& columns) const {
  struct Copied {
    Index offset;
    PlyType type;
    T* out;
  };
  std::vector<Copied> copies;
  copies.reserve(columns.size());
  for (const Column<T>& column : columns) {
    const PlyProperty* found = Find(column.property);
    if (found == nullptr) Fail(kBadFile, "{}: its {} have no property {}", path_, rows_name_, column.property);
    copies.push_back({found->offset, holds_doubles_ ? PlyType::kDouble : found->type, column.out});
  }
  // Chunks small enough to stay in the cache for all columns.
  ParallelForChunks(count_, 1024, [&](Index begin, Index end) {
    for (const Copied& copy : copies) {
      const char* bytes = first_ + copy.offset;
      for (Index i = begin; i < end; ++i) copy.out[i] = static_cast<T>(Value(bytes + i * stride_, copy.type));
    }
  });
}

template void PlyTable::Copy(const std::vector<Column<float>>& columns) const;
template void PlyTable::Copy(const std::vector<Column<double>>& columns) const;

}  // namespace vesta::gs
