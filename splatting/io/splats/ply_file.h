// A .ply file in memory: what its header says, and where the values begin.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct PlyProperty {
  std::string name;
  PlyType type;
  Index offset;  // bytes from the start of a row, in a binary file
};

// Rows of values, as many in each.
struct PlyElement {
  std::string name;
  Index count = 0;
  std::vector<PlyProperty> properties;
  Index stride = 0;   // bytes of a row, in a binary file
  std::string fault;  // why it cannot be read, nor what follows it; else empty
};

// The rows of an element of that name, for messages: "vertices", "rows of chunk".
std::string PlyRows(std::string_view element);

// Reads the header of ascii and binary_little_endian. Throws Error with one line: file and what is wrong. What a header
// says of an element matters only to those who read that, or what lies behind it (ply_table.h).
class PlyFile {
 public:
  explicit PlyFile(const std::string& path);
  // Of a file that has been read.
  PlyFile(std::string path, std::string bytes);

  const std::string& path() const { return path_; }
  bool is_ascii() const { return is_ascii_; }
  const std::vector<std::string>& comments() const { return comments_; }  // without the word "comment"
  const std::vector<PlyElement>& elements() const { return elements_; }
  bool Has(std::string_view element) const;
  std::string_view values() const { return std::string_view(bytes_).substr(values_); }  // all after the header

 private:
  void ReadProperty(std::string_view words);

  std::string path_;
  std::string bytes_;
  std::vector<std::string> comments_;
  std::vector<PlyElement> elements_;
  bool is_ascii_ = false;
  std::size_t values_ = 0;  // offset
};

}  // namespace vesta::gs
