// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <string_view>

namespace vesta::schema {
namespace {

// Levenshtein distance: fewest insertions, deletions and substitutions.
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t exchanged = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, exchanged});
    }
  }
  return row.back();
}

}  // namespace

std::string Print(double value) { return fmt::format("{}", value); }
std::string Print(Index value) { return fmt::format("{}", value); }

std::vector<std::string> SplitAt(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = text.find(separator); end != std::string::npos; end = text.find(separator, begin)) {
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

std::vector<std::string> Nearest(const std::string& name, const std::vector<std::string>& names,
                                 std::size_t max_count) {
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (const std::string& other : names) {
    // Also compare without the prefix, as in "every" for "pruning.every".
    const std::size_t dot = other.find('.');
    const std::string_view last = std::string_view(other).substr(dot == std::string::npos ? 0 : dot + 1);
    const std::size_t distance = std::min(EditDistance(name, other), EditDistance(name, last));
    if (2 * distance <= name.size()) ranked.emplace_back(distance, other);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> nearest;
  for (const auto& [distance, other] : ranked) {
    if (nearest.size() < max_count) nearest.push_back(other);
  }
  return nearest;
}

std::string FieldInfo::Allowed() const {
  const char* automatic = may_be_auto ? ", or auto" : "";
  switch (kind) {
    case Kind::kWhole:
      return fmt::format("from {} to {}, a whole number{}", range.min, range.max, automatic);
    case Kind::kNumber:
      return fmt::format("from {} to {}{}", range.min, range.max, automatic);
    case Kind::kSwitch:
      return "true or false";
    case Kind::kChoice:
      return fmt::format("{}{}{}", fmt::join(choices.begin(), choices.end() - 1, ", "),
                         choices.size() > 1 ? " or " : "", choices.back());
    case Kind::kColor:
      return fmt::format("three numbers from {} to {}, as in 0.5,0.5,0.5{}", range.min, range.max, automatic);
    case Kind::kWords:
      break;
  }
  return placeholder;
}

std::string FieldInfo::Requirement() const {
  return kind == Kind::kWords ? fmt::format("{} is missing", placeholder) : "it must be " + Allowed();
}

std::string FieldInfo::Placeholder() const {
  switch (kind) {
    case Kind::kWhole:
      return "N";
    case Kind::kNumber:
      return "X";
    case Kind::kSwitch:
      return "true|false";
    case Kind::kChoice:
      return fmt::format("{}", fmt::join(choices, "|"));
    case Kind::kColor:
      return "R,G,B";
    case Kind::kWords:
      break;
  }
  return placeholder;
}

}  // namespace vesta::schema
