// Names for the images of views.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::app {

// One .png for each view, all different: with extensions where names are the same without, and numbered where with them
// too ("a/b.jpg" beside "a_b.jpg").
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views);

}  // namespace vesta::app
