// SPDX-License-Identifier: Apache-2.0
// Whether a page is sound and stands alone.
#pragma once

#include <string>
#include <vector>

namespace vesta::test {

// What is wrong with the page, a line each: tags that do not pair, attributes without quotes, an id given twice, a
// reference that leads out of the page, a style that loads something. Elements come as ReportPage writes them.
std::vector<std::string> HtmlFaults(const std::string& page);

// The values of an attribute of all elements of a name, entities left as they are.
std::vector<std::string> AttributeValues(const std::string& page, const std::string& element, const std::string& name);

// The page without tags, styles and scripts, entities replaced.
std::string PageText(const std::string& page);

}  // namespace vesta::test
