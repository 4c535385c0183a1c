// SPDX-License-Identifier: Apache-2.0
// Checks that an HTML page is well formed and self-contained.
#pragma once

#include <string>
#include <vector>

namespace vesta::test {

// One fault a line: unpaired tags, attributes without quotes, duplicate ids, references to other resources, styles that
// load something. Expects elements as ReportPage writes them.
std::vector<std::string> HtmlFaults(const std::string& page);

// The attribute in all elements of this name, with entities unchanged.
std::vector<std::string> AttributeValues(const std::string& page, const std::string& element, const std::string& name);

// Without tags, styles and scripts, with entities replaced.
std::string PageText(const std::string& page);

}  // namespace vesta::test
