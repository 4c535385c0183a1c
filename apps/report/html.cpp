// SPDX-License-Identifier: Apache-2.0
#include "apps/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "apps/report/page.h"

namespace vesta::app {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";  // U+FFFD

// Bytes of the first UTF-8 character of the text; 0 if it is invalid.
std::size_t CharacterLength(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  // Rejects overlong forms, surrogates, and code points above U+10FFFF.
  const unsigned second = byte(1);
  if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0)) return 0;
  if ((first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90)) return 0;
  return length;
}

std::string_view OfCharacter(std::string_view character) {
  switch (character[0]) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    case '\n':
    case '\t':
      return character;
    default:
      break;
  }
  const auto first = static_cast<unsigned char>(character[0]);
  const bool is_control =
      first < 0x20 || first == 0x7f || (first == 0xc2 && static_cast<unsigned char>(character[1]) < 0xa0);
  return is_control ? kReplacement : character;
}

constexpr double kWidth = 460, kHeight = 250, kLeft = 48, kRight = 10, kTop = 30, kBottom = 34;  // pixels

using Point = std::array<double, 2>;

bool IsFinite(const Point& point) { return std::isfinite(point[0]) && std::isfinite(point[1]); }

// The range of all points along an axis. Widen makes it non-empty.
struct Extent {
  double low = INFINITY, high = -INFINITY;
  bool empty() const { return !(low <= high); }
  void Widen() {
    if (high > low) return;
    const double margin = std::max(std::abs(high) * 0.05, 1e-3);
    low -= margin, high += margin;
  }
};

Extent ExtentOf(const Chart& chart, std::size_t axis) {
  Extent extent;
  for (const Series& series : chart.series) {
    for (const Point& point : series.points) {
      if (!IsFinite(point)) continue;
      extent.low = std::min(extent.low, point[axis]);
      extent.high = std::max(extent.high, point[axis]);
    }
  }
  return extent;
}

// Maps values to pixels.
struct Frame {
  Extent x, y;
  double AtX(double value) const { return kLeft + (value - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight); }
  double AtY(double value) const {
    return kHeight - kBottom - (value - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  }
};

double StepOf(const std::vector<double>& marks) { return marks.size() > 1 ? marks[1] - marks[0] : 0; }

std::string Axes(const Frame& frame, const Chart& chart) {
  std::string svg;
  const std::vector<double> xs = RoundMarks(frame.x.low, frame.x.high, 6),
                            ys = RoundMarks(frame.y.low, frame.y.high, 8);
  for (const double mark : ys) {
    svg += fmt::format(
        R"(<line class="grid" x1="{0}" x2="{1}" y1="{2:.1f}" y2="{2:.1f}"/><text class="tick" x="{3}" y="{4:.1f}" text-anchor="end">{5}</text>)",
        kLeft, kWidth - kRight, frame.AtY(mark), kLeft - 6, frame.AtY(mark) + 4, ShortNumber(mark, StepOf(ys)));
  }
  for (const double mark : xs) {
    svg += fmt::format(R"(<text class="tick" x="{:.1f}" y="{}" text-anchor="middle">{}</text>)", frame.AtX(mark),
                       kHeight - kBottom + 15, ShortNumber(mark, StepOf(xs)));
  }
  svg += fmt::format(R"(<text class="tick" x="{}" y="{}" text-anchor="end">{}</text>)", kWidth - kRight, kHeight - 4,
                     Escape(chart.x_label));
  return svg;
}

std::string Curve(const Frame& frame, const Series& series) {
  std::string points, dots;
  for (const Point& point : series.points) {
    if (!IsFinite(point)) continue;
    const double x = frame.AtX(point[0]), y = frame.AtY(point[1]);
    points += fmt::format("{:.1f},{:.1f} ", x, y);
    dots += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="2"><title>{}: {:.5g} at {:.5g}</title></circle>)", x, y,
                        Escape(series.name), point[1], point[0]);
  }
  if (points.empty()) return "";
  points.pop_back();
  return fmt::format(R"(<g class="run{}{}"><polyline points="{}"/>{}</g>)", series.color % kRunColors,
                     series.is_dashed ? " dashed" : "", points, dots);
}

}  // namespace

std::string Escape(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = CharacterLength(text);
    escaped += length == 0 ? kReplacement : OfCharacter(text.substr(0, length));
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return escaped;
}

std::string DataUri(std::string_view type, std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = "data:";
  uri += type;
  uri += ";base64,";
  uri.reserve(uri.size() + 4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      triple = triple << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      uri += i + j > bytes.size() ? '=' : kDigits[triple >> (18 - 6 * j) & 63];
    }
  }
  return uri;
}

std::string ShortNumber(double value, double step) {
  const double size = std::max(std::abs(value), step);
  const auto [unit, suffix] = size >= 1e9   ? std::pair(1e9, "G")
                              : size >= 1e6 ? std::pair(1e6, "M")
                              : size >= 1e4 ? std::pair(1e3, "k")
                                            : std::pair(1.0, "");
  if (value == 0) return "0";
  const int digits = step > 0 ? std::clamp(static_cast<int>(-std::floor(std::log10(step / unit) + 1e-9)), 0, 6) : 2;
  return fmt::format("{:.{}f}{}", value / unit, digits, suffix);
}

std::vector<double> RoundMarks(double low, double high, int count) {
  const double rough = (high - low) / count, power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough) step = factor * power;
  }
  std::vector<double> marks;
  for (double mark = std::ceil(low / step - 1e-9); mark * step <= high + 1e-9 * step; ++mark) {
    marks.push_back(mark * step);
  }
  return marks;
}

std::string ToSvg(const Chart& chart) {
  std::string svg = fmt::format(
      R"(<svg class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}"><text class="title" x="{}" y="18">{}</text>)",
      kWidth, kHeight, Escape(chart.title), kLeft, Escape(chart.title));
  Frame frame{ExtentOf(chart, 0), ExtentOf(chart, 1)};
  if (frame.x.empty()) {
    svg += fmt::format(R"(<text class="tick" x="{}" y="{}">no data</text>)", kLeft, kHeight / 2);
  } else {
    frame.x.Widen(), frame.y.Widen();
    svg += Axes(frame, chart);
    for (const Series& series : chart.series) svg += Curve(frame, series);
  }
  return svg + "</svg>\n";
}

}  // namespace vesta::app
