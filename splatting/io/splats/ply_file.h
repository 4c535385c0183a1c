// SPDX-License-Identifier: Apache-2.0
// A .ply file in memory: its header, and its elements as tables.
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

// A .ply file in memory: its header, and where the values begin. Reads the header of ascii and binary_little_endian.
// Throws Error with one line: file and what is wrong. What a header says of an element matters only to those who read
// that, or what lies behind it (PlyTable).
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

// One element of a .ply file, as vertices, whatever its properties are: a table of numbers.
// Throws Error with one line: file and what is wrong. Neither the element nor one before it may have lists; what comes
// later is ignored. A count in the header allocates nothing before the file has been found long enough for it.
class PlyTable {
 public:
  // The file outlives the table.
  PlyTable(const PlyFile& file, std::string_view element);

  Index count() const { return count_; }
  bool Has(std::string_view property) const { return Find(property) != nullptr; }
  // Number of properties whose names begin so.
  int CountWithPrefix(std::string_view prefix) const;
  // Whether there is a property of that name and type.
  bool Has(std::string_view property, PlyType type) const;
  // The largest value of an 8- or 16-bit unsigned property, 1 for other types: colours divide by it.
  float FullScale(std::string_view property) const;

  // T: float or double.
  template <class T>
  struct Column {
    std::string property;
    T* out;  // count() values
  };
  // Fills the columns, in parallel over rows.
  template <class T>
  void Copy(const std::vector<Column<T>>& columns) const;

 private:
  void FindBinary(const PlyFile& file, const PlyElement& element);
  void ParseAscii(const PlyFile& file, const PlyElement& element);
  const PlyProperty* Find(std::string_view property) const;

  std::string path_;
  std::string rows_name_;  // "vertices"
  std::vector<PlyProperty> properties_;
  bool holds_doubles_;  // for all properties, whatever their types are: those of an ascii file
  std::string parsed_;  // of an ascii file
  Index count_ = 0;
  Index stride_ = 0;  // bytes of a row
  const char* first_ = nullptr;
};

}  // namespace vesta::gs
