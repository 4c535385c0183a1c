#include "splatting/io/splats/ply_file.h"

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/text_file.h"

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

std::string PlyRows(std::string_view element) {
  return element == "vertex" ? "vertices" : fmt::format("rows of {}", Printable(element));
}

PlyFile::PlyFile(const std::string& path) : PlyFile(path, ReadFile(path)) {}

PlyFile::PlyFile(std::string path, std::string bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {
  std::string_view rest = bytes_, line;
  if (rest.starts_with("\x1f\x8b")) Fail("{}: compressed by gzip; unpack it first: gunzip", path_);
  if (!TakeLine(&rest, &line) || line != "ply") Fail("{}: not a .ply file", path_);
  bool has_format = false;
  while (true) {
    if (!TakeLine(&rest, &line))
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
      if (elements_.size() == kMaxElements) Fail("{}: more than {} elements", path_, kMaxElements);
      PlyElement& element = elements_.emplace_back();
      element.name = NextWord(&words);
      if (!ParseNumber(NextWord(&words), &element.count) || element.count < 0) {
        element.fault =
            fmt::format("the header's number of {} is not a whole number that can be used", PlyRows(element.name));
      }
    } else if (key == "property" && !elements_.empty()) {
      ReadProperty(words);
    }
  }
  if (!has_format) Fail("{}: the header has no format line; export the file again", path_);
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
    element.fault = "the header has a property without a name of its own";
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

}  // namespace vesta::gs
