// SPDX-License-Identifier: Apache-2.0
// Names for the images of views.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// One .png for each view, such that no two files are the same: with extensions where they would be without, and
// numbered where with them too ("a/b.jpg" beside "a_b.jpg"). files_of(name): the files of an image of that name, itself
// the first.
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<std::vector<std::string>(const std::string&)>& files_of);

}  // namespace vesta::app
