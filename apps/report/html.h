// SPDX-License-Identifier: Apache-2.0
// Text, images and charts for an HTML page without external files.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace vesta::app {

// Escapes any bytes for the text or a quoted attribute of a page. Control characters and invalid UTF-8 become U+FFFD.
// Use it for all names of files and views, which are untrusted.
std::string Escape(std::string_view text);

// A URL that contains the file: "data:TYPE;base64,...". type: for example "image/jpeg".
std::string DataUri(std::string_view type, std::string_view bytes);

// One curve of a chart.
struct Series {
  std::string name;
  std::size_t color = 0;  // colour of the run (page.h); repeats after kRunColors
  bool is_dashed = false;
  std::vector<std::array<double, 2>> points;  // x, y; skipped if not finite
};

struct Chart {
  std::string title, x_label;
  std::vector<Series> series;
};

// The chart as SVG, with escaped texts. Without a finite point, it shows a note.
std::string ToSvg(const Chart& chart);

// A mark's label: "0.25", "120k", "1.5M". step: distance of the marks, which determines the number of digits.
std::string ShortNumber(double value, double step);

// About `count` round numbers within [low, high], for the marks of an axis. high > low.
std::vector<double> RoundMarks(double low, double high, int count);

}  // namespace vesta::app
