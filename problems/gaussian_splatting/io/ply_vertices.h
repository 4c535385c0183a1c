// The vertex element of a .ply file, whatever its properties are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

// Reads ascii and binary_little_endian; the vertex element must come before elements with lists; later elements are
// ignored. Throws Error with one line: file and what is wrong. A count in the header allocates nothing before the
// file has been found long enough for it.
class PlyVertices {
 public:
  explicit PlyVertices(const std::string& path);

  Index count() const { return count_; }
  const std::vector<std::string>& comments() const { return comments_; }  // without the word "comment"
  bool Has(std::string_view property) const { return Find(property) != nullptr; }
  // Number of properties whose names begin so.
  int CountWithPrefix(std::string_view prefix) const;
  // The largest value of an 8- or 16-bit unsigned property, 1 for other types: colours divide by it.
  float FullScale(std::string_view property) const;

  // T: float or double.
  template <class T>
  struct Column {
    std::string property;
    T* out;  // count() values
  };
  // Fills the columns, in parallel over vertices.
  template <class T>
  void Copy(const std::vector<Column<T>>& columns) const;

 private:
  enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
  struct Property {
    std::string name;
    Type type;
    Index offset;      // bytes from the start of a vertex
    float full_scale;  // see FullScale
  };

  static Type ParseType(std::string_view word, const std::string& where);
  static Index TypeSize(Type type);
  void ReadHeader(std::string_view* rest);
  void ParseAscii(std::string_view words);
  const Property* Find(std::string_view property) const;
  static double Value(const char* bytes, Type type);

  std::string path_;
  std::string bytes_;
  std::vector<std::string> comments_;
  std::vector<Property> properties_;
  bool is_ascii_ = false;
  Index count_ = 0;
  Index stride_ = 0;  // bytes of a vertex
  Index first_ = 0;   // offset of the first vertex in bytes_
};

}  // namespace vesta::gs
