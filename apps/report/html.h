// SPDX-License-Identifier: Apache-2.0
// Text, images and curves as parts of a page that stands alone.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace vesta::app {

// Any bytes as text of a page or value of a quoted attribute: the characters that mean something there as entities,
// what is no UTF-8 and control characters as U+FFFD. Names of files and views are not to be trusted.
std::string Escape(std::string_view text);

// "data:TYPE;base64,...": a file within the page. type: as "image/jpeg".
std::string DataUri(std::string_view type, std::string_view bytes);

// Curves as SVG, in the colours of the page (page.h).
struct Series {
  std::string name;
  std::size_t color = 0;  // of the page's, which repeat
  bool is_dashed = false;
  std::vector<std::array<double, 2>> points;  // x, y; those that are not finite are left out
};

struct Chart {
  std::string title, x_label;
  std::vector<Series> series;
};

// Names are escaped here. Without a finite point the chart says so.
std::string ToSvg(const Chart& chart);

// A number of some axis whose marks lie `step` apart, short: "0.25", "120k", "1.5M".
std::string ShortNumber(double value, double step);

// Marks of an axis: round numbers from within [low, high], about `count` of them. high > low.
std::vector<double> RoundMarks(double low, double high, int count);

}  // namespace vesta::app
