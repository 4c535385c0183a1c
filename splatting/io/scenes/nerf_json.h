// SPDX-License-Identifier: Apache-2.0
// Reads the JSON of NeRF scenes, and names the frame of a value that is not a number.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace vesta::gs {

// Throws Error if the file cannot be read, or if it is not valid JSON. For NaN and Infinity, which JSON does not have
// but Python writes for a failed pose, the message names the frame.
nlohmann::json ReadJson(const std::string& path);

}  // namespace vesta::gs
