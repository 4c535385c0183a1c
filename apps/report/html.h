// SPDX-License-Identifier: Apache-2.0
// Text, images and charts for a self-contained HTML page.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace vesta::app {

// Escapes any bytes for the text of a page or a quoted attribute: special characters become entities; control
// characters and invalid UTF-8 become U+FFFD. Names of files and views are untrusted input.
std::string Escape(std::string_view text);

// "data:TYPE;base64,...": a file embedded in the page. type: for example "image/jpeg".
std::string DataUri(std::string_view type, std::string_view bytes);

// A curve of a chart, in a colour of the page (page.h).
struct Series {
  std::string name;
  std::size_t color = 0;  // number of a colour; colours repeat after kRunColors
  bool is_dashed = false;
  std::vector<std::array<double, 2>> points;  // x, y; points that are not finite are skipped
};

struct Chart {
  std::string title, x_label;
  std::vector<Series> series;
};

// Draws the chart as SVG and escapes its names. Without a finite point, the chart shows a note instead.
std::string ToSvg(const Chart& chart);

// A short label of an axis whose marks are `step` apart: "0.25", "120k", "1.5M".
std::string ShortNumber(double value, double step);

// Marks of an axis: about `count` round numbers within [low, high]. high > low.
std::vector<double> RoundMarks(double low, double high, int count);

}  // namespace vesta::app
