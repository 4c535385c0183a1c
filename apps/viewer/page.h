// SPDX-License-Identifier: Apache-2.0
// The viewer's page. It sends no requests to other servers.
#pragma once

#include <string>
#include <string_view>

namespace vesta::app {

std::string_view ViewerPage();   // HTML
std::string_view ViewerStyle();  // CSS
std::string ViewerScript();      // JavaScript: the two scripts below, concatenated

// JavaScript that moves the camera and requests images.
std::string_view ViewerCameraScript();
// JavaScript of the panel beside the image: photographs, state of a training, buttons.
std::string_view ViewerPanelScript();

}  // namespace vesta::app
