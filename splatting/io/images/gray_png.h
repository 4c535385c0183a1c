// Grey images of 16 bits, for what is measured and no picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

// A PNG of one channel of 16 bits, linear; values row by row. comment: one line of ASCII on what they mean, which the
// file carries (chunk tEXt, "Comment"). Written whole or not at all (atomic_file.h).
void SaveGrayPng(const std::string& path, ImageSize size, const std::vector<std::uint16_t>& values,
                 const std::string& comment);

}  // namespace vesta::gs
