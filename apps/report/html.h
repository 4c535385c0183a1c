// SPDX-License-Identifier: Apache-2.0
// Makes text, images and charts for an HTML page without external files.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace vesta::app {

// Escapes any bytes for the text or a quoted attribute of an HTML page. Special characters become entities; control
// characters and invalid UTF-8 become U+FFFD. Use it for all names of files and views, which are untrusted input.
std::string Escape(std::string_view text);

// Returns a file as a URL that contains it: "data:TYPE;base64,...". type: for example "image/jpeg".
std::string DataUri(std::string_view type, std::string_view bytes);

// One curve of a chart.
struct Series {
  std::string name;
  std::size_t color = 0;  // 0, 1, ...: colour of the run (page.h); colours repeat after kRunColors
  bool is_dashed = false;
  std::vector<std::array<double, 2>> points;  // x, y; points that are not finite are skipped
};

struct Chart {
  std::string title, x_label;
  std::vector<Series> series;
};

// Returns the chart as SVG; its texts are escaped. Without a finite point, the chart shows a note instead of curves.
std::string ToSvg(const Chart& chart);

// Returns a short label for a mark of an axis: "0.25", "120k", "1.5M". step: distance of the marks, which determines
// the digits.
std::string ShortNumber(double value, double step);

// Returns the marks of an axis: about `count` round numbers within [low, high]. high > low.
std::vector<double> RoundMarks(double low, double high, int count);

}  // namespace vesta::app
