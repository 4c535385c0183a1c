// SPDX-License-Identifier: Apache-2.0
// Finds photographs whose names in the model and on disk are spelled differently.
#pragma once

#include <string>

namespace vesta::gs {

// The path of the photograph `name` in a folder. If no such file exists: the only file there whose name is equal except
// for upper and lower case, else the only image whose name differs only in the extension. Returns folder/name if no
// file or several files fit.
std::string FindPhotograph(const std::string& folder, const std::string& name);

// The name of a photograph from Windows, with / in place of each backslash.
std::string WithSlashes(std::string name);

}  // namespace vesta::gs
