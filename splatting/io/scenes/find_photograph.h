// SPDX-License-Identifier: Apache-2.0
// Finds photographs whose files are spelled differently from their names in the model.
#pragma once

#include <map>
#include <string>

namespace vesta::gs {

// Lists each folder at most once.
class PhotographFinder {
 public:
  // The path of the photograph `name` in a folder. If no file has this name: the only file whose name differs just in
  // upper and lower case. If there are several such files, or none: the only image whose name differs just in the
  // extension, or else folder/name.
  std::string Find(const std::string& folder, const std::string& name);

 private:
  // The path of the only file with a key; empty if several files have it.
  using Paths = std::map<std::string, std::string>;
  struct Listing {
    Paths by_name;  // keys: names of files, in lower case
    Paths by_stem;  // keys: names of images without their extension, in lower case
  };
  const Listing& List(const std::string& folder);

  std::map<std::string, Listing> listings_;
};

// The name of a photograph from Windows, with / in place of each backslash.
std::string WithSlashes(std::string name);

}  // namespace vesta::gs
