// SPDX-License-Identifier: Apache-2.0
// What a viewer's page is made of. It asks nothing of any other server.
#pragma once

#include <string>
#include <string_view>

namespace vesta::app {

std::string_view ViewerPage();   // HTML
std::string_view ViewerStyle();  // CSS
std::string ViewerScript();      // JavaScript: the two below, one after the other

// How the camera moves and pictures are asked for.
std::string_view ViewerCameraScript();
// What stands beside the picture: photographs, how a training goes, its buttons.
std::string_view ViewerPanelScript();

}  // namespace vesta::app
