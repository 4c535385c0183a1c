// SPDX-License-Identifier: Apache-2.0
// Text and images as parts of a page that stands alone.
#pragma once

#include <string>
#include <string_view>

namespace vesta::app {

// Any bytes as text of a page or value of a quoted attribute: the characters that mean something there as entities,
// what is no UTF-8 and control characters as U+FFFD. Names of files and views are not to be trusted.
std::string Escape(std::string_view text);

// "data:TYPE;base64,...": a file within the page. type: as "image/jpeg".
std::string DataUri(std::string_view type, std::string_view bytes);

}  // namespace vesta::app
