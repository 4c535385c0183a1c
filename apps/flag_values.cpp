#include "apps/flag_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace vesta::app {
namespace {

template <class T>
std::optional<T> ParseAll(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string TypeOf(const FlagRule& rule) { return gflags::GetCommandLineFlagInfoOrDie(rule.name).type; }

// One call for each kind of value: whether the text is one, what is allowed in words, and the help's placeholder.
struct IsAllowed {
  const std::string& text;
  const std::string& type;

  bool operator()(const Range& range) const {
    const bool is_whole = type == "double" || ParseAll<std::int64_t>(text) || ParseAll<std::uint64_t>(text);
    const std::optional<double> value = ParseAll<double>(text);
    return is_whole && value && *value >= range.min && *value <= range.max;
  }
  bool operator()(const Choice& choice) const {
    return std::find(choice.names.begin(), choice.names.end(), text) != choice.names.end();
  }
  bool operator()(const Color&) const {
    std::array<float, 3> color;
    return ParseColor(text, &color);
  }
  bool operator()(const Switch&) const { return text == "true" || text == "false"; }
  bool operator()(const Text&) const { return !text.empty(); }
};

struct Requirement {
  const std::string& type;

  std::string operator()(const Range& range) const {
    const char* kind = type == "double" ? "a number" : "a whole number";
    if (range.max >= 1e9) return fmt::format("must be {}, at least {} and at most {:g}", kind, range.min, range.max);
    return fmt::format("must be {} to {}{}", range.min, range.max, type == "double" ? "" : ", a whole number");
  }
  std::string operator()(const Choice& choice) const {
    if (choice.names.size() == 1) return fmt::format("must be {}, the only one so far", choice.names[0]);
    const auto last = choice.names.end() - 1;
    return fmt::format("must be {} or {}", fmt::join(choice.names.begin(), last, ", "), *last);
  }
  std::string operator()(const Color&) const { return "must be three numbers from 0 to 1, as in 0.5,0.5,0.5"; }
  std::string operator()(const Switch&) const { return "must be true or false"; }
  std::string operator()(const Text& value) const { return fmt::format("{} is missing", value.placeholder); }
};

struct Placeholder {
  const std::string& type;

  std::string operator()(const Range&) const { return type == "double" ? "X" : "N"; }
  std::string operator()(const Choice& choice) const { return fmt::format("{}", fmt::join(choice.names, "|")); }
  std::string operator()(const Color&) const { return "R,G,B"; }
  std::string operator()(const Switch&) const { return ""; }
  std::string operator()(const Text& value) const { return value.placeholder; }
};

}  // namespace

void CheckFlagValue(const FlagRule& rule, const std::string& text) {
  const std::string type = TypeOf(rule);
  if (std::visit(IsAllowed{text, type}, rule.values)) return;
  throw UsageError(fmt::format("--{}={}: {}", rule.name, text, std::visit(Requirement{type}, rule.values)));
}

bool ParseColor(const std::string& text, std::array<float, 3>* color) {
  std::string_view rest = text;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t comma = i < 2 ? rest.find(',') : rest.size();
    if (comma == std::string_view::npos) return false;
    const std::optional<float> value = ParseAll<float>(rest.substr(0, comma));
    if (!value || !(*value >= 0 && *value <= 1)) return false;
    (*color)[i] = *value;
    rest.remove_prefix(i < 2 ? comma + 1 : comma);
  }
  return true;
}

std::string ValuePlaceholder(const FlagRule& rule) {
  const std::string type = TypeOf(rule);
  return std::visit(Placeholder{type}, rule.values);
}

}  // namespace vesta::app
