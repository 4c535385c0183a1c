#include "problems/gaussian_splatting/io/ply_vertices.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/io/byte_reader.h"

namespace vesta::gs {
namespace {

constexpr std::size_t kMaxProperties = 1000;

// Cuts the first line off `text`, without its end; false where there is none that is ended.
bool TakeLine(std::string_view* text, std::string_view* line) {
  const std::size_t end = text->find('\n');
  if (end == std::string_view::npos) return false;
  *line = text->substr(0, end);
  if (line->ends_with('\r')) line->remove_suffix(1);
  text->remove_prefix(end + 1);
  return true;
}

}  // namespace

PlyVertices::Type PlyVertices::ParseType(std::string_view word, const std::string& where) {
  static constexpr std::pair<std::string_view, Type> kTypes[] = {
      {"float", Type::kFloat},   {"float32", Type::kFloat}, {"double", Type::kDouble}, {"float64", Type::kDouble},
      {"uchar", Type::kUint8},   {"uint8", Type::kUint8},   {"char", Type::kInt8},     {"int8", Type::kInt8},
      {"ushort", Type::kUint16}, {"uint16", Type::kUint16}, {"short", Type::kInt16},   {"int16", Type::kInt16},
      {"uint", Type::kUint32},   {"uint32", Type::kUint32}, {"int", Type::kInt32},     {"int32", Type::kInt32}};
  for (const auto& [name, type] : kTypes) {
    if (word == name) return type;
  }
  Fail("{}: unknown property type '{}' in the header; export the file again", where, Printable(word));
}

Index PlyVertices::TypeSize(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kDouble:
      return 8;
    default:
      return 4;
  }
}

PlyVertices::PlyVertices(const std::string& path) : path_(path), bytes_(ReadFile(path)) {
  std::string_view rest = bytes_;
  ReadHeader(&rest);
  const Index left = static_cast<Index>(rest.size());
  // A word of an ascii file takes two characters, white space included, but for the last of the file.
  const Index bytes_each = is_ascii_ ? 2 * static_cast<Index>(properties_.size()) : stride_;
  const Index most = is_ascii_ ? (left + 1) / bytes_each : left / bytes_each;
  if (count_ > most) {
    Fail(
        "{}: the header counts {} vertices, but the {} bytes after it hold {} at most; the file is cut short or "
        "damaged",
        path_, count_, left, most);
  }
  if (is_ascii_) {
    ParseAscii(rest);
  } else {
    first_ = static_cast<Index>(bytes_.size() - rest.size());
  }
}

void PlyVertices::ReadHeader(std::string_view* rest) {
  std::string_view line;
  if (rest->starts_with("\x1f\x8b")) Fail("{}: compressed by gzip; unpack it first: gunzip", path_);
  if (!TakeLine(rest, &line) || line != "ply") Fail("{}: not a .ply file", path_);
  bool has_format = false;
  int elements = 0;  // seen so far
  bool in_vertex = false;
  while (true) {
    if (!TakeLine(rest, &line))
      Fail("{}: the header has no end_header; the file is cut short or damaged, copy or export it again", path_);
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
      if (!has_format) Fail("{}: its format {} is not read; export as binary_little_endian", path_, Printable(format));
    } else if (key == "element") {
      const std::string_view element = NextWord(&words);
      // The chunks of the compressed splats that PlayCanvas and SuperSplat write.
      if (element == "chunk") Fail("{}: a compressed splat; export it as an ordinary .ply, uncompressed", path_);
      in_vertex = element == "vertex";
      if (in_vertex && elements > 0) Fail("{}: the vertices are not the first element; export the file again", path_);
      if (in_vertex && (!ParseNumber(NextWord(&words), &count_) || count_ < 0)) {
        Fail("{}: the header's number of vertices is not a whole number that can be used; export the file again",
             path_);
      }
      ++elements;
    } else if (key == "property" && in_vertex) {
      const Type type = ParseType(NextWord(&words), path_);
      const std::string_view name = NextWord(&words);
      if (name.empty() || Has(name)) {
        Fail("{}: the header has a property without a name of its own; export the file again", path_);
      }
      if (properties_.size() == kMaxProperties) Fail("{}: more than {} properties a vertex", path_, kMaxProperties);
      const float full_scale = type == Type::kUint8 ? 255.0f : type == Type::kUint16 ? 65535.0f : 1.0f;
      properties_.push_back({std::string(name), type, stride_, full_scale});
      stride_ += TypeSize(type);
    }
  }
  if (!has_format) Fail("{}: the header has no format line; export the file again", path_);
  if (properties_.empty()) Fail("{}: it has no vertices with properties", path_);
}

void PlyVertices::ParseAscii(std::string_view words) {
  // Brought into the shape of a binary file whose properties are all doubles.
  stride_ = 0;
  for (Property& property : properties_) {
    property.type = Type::kDouble;
    property.offset = std::exchange(stride_, stride_ + Index{sizeof(double)});
  }
  std::string values(static_cast<std::size_t>(count_ * stride_), '\0');
  char* out = values.data();
  for (Index i = 0; i < count_; ++i) {
    for (const Property& property : properties_) {
      double value = 0;
      if (!ParseNumber(NextWord(&words), &value)) {
        Fail(
            "{}: {} of vertex {} is missing or not a number; the file is cut short or damaged, copy or export it again",
            path_, Printable(property.name), i);
      }
      std::memcpy(out, &value, sizeof(value));
      out += sizeof(value);
    }
  }
  bytes_ = std::move(values);
}

const PlyVertices::Property* PlyVertices::Find(std::string_view property) const {
  const auto it =
      std::find_if(properties_.begin(), properties_.end(), [&](const Property& p) { return p.name == property; });
  return it == properties_.end() ? nullptr : &*it;
}

int PlyVertices::CountWithPrefix(std::string_view prefix) const {
  return static_cast<int>(std::count_if(properties_.begin(), properties_.end(),
                                        [&](const Property& p) { return p.name.starts_with(prefix); }));
}

float PlyVertices::FullScale(std::string_view property) const {
  const Property* found = Find(property);
  return found == nullptr ? 1.0f : found->full_scale;
}

double PlyVertices::Value(const char* bytes, Type type) {
  const auto read = [bytes](auto value) {
    std::memcpy(&value, bytes, sizeof(value));
    return static_cast<double>(value);
  };
  switch (type) {
    case Type::kInt8:
      return read(std::int8_t{});
    case Type::kUint8:
      return read(std::uint8_t{});
    case Type::kInt16:
      return read(std::int16_t{});
    case Type::kUint16:
      return read(std::uint16_t{});
    case Type::kInt32:
      return read(std::int32_t{});
    case Type::kUint32:
      return read(std::uint32_t{});
    case Type::kDouble:
      return read(double{});
    case Type::kFloat:
      break;
  }
  return read(float{});
}

template <class T>
void PlyVertices::Copy(const std::vector<Column<T>>& columns) const {
  std::vector<std::pair<const Property*, T*>> copies;
  for (const Column<T>& column : columns) {
    copies.emplace_back(Find(column.property), column.out);
    if (copies.back().first == nullptr) Fail("{}: its vertices have no property {}", path_, column.property);
  }
  // Chunks that stay in the cache while the columns pass over them.
  ParallelForChunks(count_, 1024, [&](Index begin, Index end) {
    for (const auto& [property, out] : copies) {
      const char* bytes = bytes_.data() + first_ + property->offset;
      for (Index i = begin; i < end; ++i) out[i] = static_cast<T>(Value(bytes + i * stride_, property->type));
    }
  });
}

template void PlyVertices::Copy(const std::vector<Column<float>>& columns) const;
template void PlyVertices::Copy(const std::vector<Column<double>>& columns) const;

}  // namespace vesta::gs
