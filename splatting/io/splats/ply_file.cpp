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

Index SizeOf(PlyType type) {
  return std::ranges::find_if(kTypes, [type](const TypeName& known) { return known.type == type; })->size;
}

const TypeName* FindType(std::string_view name) {
  const auto* type = std::ranges::find_if(kTypes, [name](const TypeName& known) { return known.name == name; });
  return type == std::end(kTypes) ? nullptr : type;
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

double BigEndianValue(const char* bytes, PlyType type) {
  char reversed[8];
  std::reverse_copy(bytes, bytes + SizeOf(type), reversed);
  return Value(reversed, type);
}

bool HasLists(const PlyElement& element) {
  return std::ranges::any_of(element.properties, [](const PlyProperty& p) { return p.count_type.has_value(); });
}

// Removes the rows of an element from `left`. Returns false if there are too few bytes.
bool SkipRows(const PlyElement& element, bool is_big_endian, std::string_view* left) {
  const auto take = [left](Index bytes) {
    if (bytes < 0 || bytes > static_cast<Index>(left->size())) return false;
    left->remove_prefix(static_cast<std::size_t>(bytes));
    return true;
  };
  if (!HasLists(element)) return take(element.count * element.stride);
  for (Index i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      Index values = 1;
      if (property.count_type) {
        const char* bytes = left->data();
        if (!take(SizeOf(*property.count_type))) return false;
        const double count =
            is_big_endian ? BigEndianValue(bytes, *property.count_type) : Value(bytes, *property.count_type);
        if (!(count >= 0 && count <= static_cast<double>(left->size()))) return false;
        values = static_cast<Index>(count);
      }
      if (!take(values * SizeOf(property.type))) return false;
    }
  }
  return true;
}

// The same for an ascii file.
bool SkipAsciiRows(const PlyElement& element, std::string_view* words) {
  for (Index i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      Index values = 1;
      if (property.count_type && (!ParseNumber(NextWord(words), &values) || values < 0)) return false;
      for (Index k = 0; k < values; ++k) {
        if (NextWord(words).empty()) return false;
      }
    }
  }
  return true;
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
      is_big_endian_ = format == "binary_big_endian";
      has_format = is_ascii_ || is_big_endian_ || format == "binary_little_endian";
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
  std::string_view type_name = NextWord(&words);
  const bool is_list = type_name == "list";
  const TypeName* count_type = is_list ? FindType(NextWord(&words)) : nullptr;
  if (is_list) type_name = NextWord(&words);
  const std::string_view name = NextWord(&words);
  const TypeName* type = FindType(type_name);
  const auto has_name = [&](const PlyProperty& other) { return other.name == name; };
  if (type == nullptr || (is_list && count_type == nullptr)) {
    element.fault = fmt::format("unknown property type '{}' in the header", Printable(type_name));
  } else if (name.empty() || std::any_of(element.properties.begin(), element.properties.end(), has_name)) {
    element.fault = "the header has a property without a unique name";
  } else if (element.properties.size() == kMaxProperties) {
    element.fault = fmt::format("more than {} properties in a row", kMaxProperties);
  } else {
    element.properties.push_back({std::string(name), type->type, element.stride});
    if (is_list) element.properties.back().count_type = count_type->type;
    element.stride += is_list ? count_type->size : type->size;
  }
}

bool PlyFile::Has(std::string_view element) const {
  return std::any_of(elements_.begin(), elements_.end(), [&](const PlyElement& e) { return e.name == element; });
}

PlyTable::PlyTable(const PlyFile& file, std::string_view name)
    : path_(file.path()), is_big_endian_(file.is_big_endian()), holds_doubles_(file.is_ascii()) {
  for (const PlyElement& element : file.elements()) {
    if (!element.fault.empty()) Fail(kBadFile, "{}: {}; export the file again", path_, element.fault);
    if (element.name != name) continue;
    rows_name_ = PlyRows(element.name);
    if (element.properties.empty()) break;
    if (HasLists(element)) {
      Fail(kBadFile, "{}: its {} have a property that is a list; export the file again", path_, rows_name_);
    }
    properties_ = element.properties;
    count_ = element.count;
    file.is_ascii() ? ParseAscii(file, element) : FindBinary(file, element);
    return;
  }
  Fail(kBadFile, "{}: it has no {} with properties", path_, PlyRows(name));
}

void PlyTable::FailTruncated(const PlyElement& element) const {
  Fail(kBadFile, "{}: it ends within the {}, or one of their lists is damaged; copy or export it again", path_,
       PlyRows(element.name));
}

// Also checks the size of the elements before this one.
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
    if (!SkipRows(other, is_big_endian_, &left)) FailTruncated(other);
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
    if (!SkipAsciiRows(other, &words)) FailTruncated(other);
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
      if (is_big_endian_) {
        for (Index i = begin; i < end; ++i)
          copy.out[i] = static_cast<T>(BigEndianValue(bytes + i * stride_, copy.type));
        continue;
      }
      for (Index i = begin; i < end; ++i) copy.out[i] = static_cast<T>(Value(bytes + i * stride_, copy.type));
    }
  });
}

template void PlyTable::Copy(const std::vector<Column<float>>& columns) const;
template void PlyTable::Copy(const std::vector<Column<double>>& columns) const;

}  // namespace vesta::gs
