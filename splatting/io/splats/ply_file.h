// SPDX-License-Identifier: Apache-2.0
// A .ply file in memory: its header, and its elements as tables.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct PlyProperty {
  std::string name;
  PlyType type;
  Index offset;                                      // bytes from the start of a row in a binary file without lists
  std::optional<PlyType> count_type = std::nullopt;  // of a list: the type of its count
};

// Rows with the same properties.
struct PlyElement {
  std::string name;
  Index count = 0;
  std::vector<PlyProperty> properties;
  Index stride = 0;   // bytes per row in a binary file; with lists: size of the counts and other properties
  std::string fault;  // if not empty, the reason why neither this element nor later ones can be read
};

// For messages: "vertices", "rows of chunk".
std::string PlyRows(std::string_view element);

// A .ply file in memory: its parsed header, and its values as bytes. The formats ascii, binary_little_endian
// and binary_big_endian are supported. The constructors throw Error, in one line with the file and the problem. If only
// the description of an element is wrong, the constructor of a PlyTable for that element or a later one throws Error
// instead (PlyElement::fault).
class PlyFile {
 public:
  explicit PlyFile(const std::string& path);
  // bytes: the content of the file.
  PlyFile(std::string path, std::string bytes);

  const std::string& path() const { return path_; }
  bool is_ascii() const { return is_ascii_; }
  bool is_big_endian() const { return is_big_endian_; }
  const std::vector<std::string>& comments() const { return comments_; }  // without the word "comment"
  const std::vector<PlyElement>& elements() const { return elements_; }
  bool Has(std::string_view element) const;
  std::string_view values() const { return std::string_view(bytes_).substr(values_); }  // all bytes after the header

 private:
  void ReadProperty(std::string_view words);

  std::string path_;
  std::string bytes_;
  std::vector<std::string> comments_;
  std::vector<PlyElement> elements_;
  bool is_ascii_ = false;
  bool is_big_endian_ = false;
  std::size_t values_ = 0;  // offset of the values in bytes_
};

// One element of a .ply file, such as its vertices, as a table of numbers. The element may not have list properties.
// Other elements are ignored. Functions throw Error, in one line with the file and the
// problem. The number of rows in the header is checked against the length of the file before memory is allocated.
class PlyTable {
 public:
  // The file must outlive the table.
  PlyTable(const PlyFile& file, std::string_view element);

  Index count() const { return count_; }
  bool Has(std::string_view property) const { return Find(property) != nullptr; }
  int CountWithPrefix(std::string_view prefix) const;
  bool Has(std::string_view property, PlyType type) const;
  // The value of full brightness if the property is a colour: 255 or 65535 for 8 or 16 unsigned bits, else 1.
  float FullScale(std::string_view property) const;

  // T: float or double.
  template <class T>
  struct Column {
    std::string property;
    T* out;  // receives count() values
  };
  // Copies columns, in parallel over rows. Throws Error if the element lacks one of them.
  template <class T>
  void Copy(const std::vector<Column<T>>& columns) const;

 private:
  void FindBinary(const PlyFile& file, const PlyElement& element);
  void ParseAscii(const PlyFile& file, const PlyElement& element);
  [[noreturn]] void FailTruncated(const PlyElement& element) const;
  const PlyProperty* Find(std::string_view property) const;

  std::string path_;
  std::string rows_name_;  // "vertices"
  std::vector<PlyProperty> properties_;
  bool is_big_endian_;  // the values at first_
  bool holds_doubles_;  // the values at first_ are doubles, parsed from an ascii file
  std::string parsed_;  // bytes of these doubles
  Index count_ = 0;
  Index stride_ = 0;             // bytes per row
  const char* first_ = nullptr;  // the first row
};

}  // namespace vesta::gs
