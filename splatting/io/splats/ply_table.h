// One element of a .ply file, as vertices, whatever its properties are: a table of numbers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"
#include "splatting/io/splats/ply_file.h"

namespace vesta::gs {

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
