// SPDX-License-Identifier: Apache-2.0
// Curves as SVG, in the colours of the page (page.h).
#pragma once

#include <array>
#include <string>
#include <vector>

namespace vesta::app {

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
