// SPDX-License-Identifier: Apache-2.0
// Tables of options: name, allowed values and help text of each field of a struct. Command-line flags, help, checks,
// configuration files and the options of benchmarks are generated from them.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "kernels/core/files.h"
#include "kernels/core/span.h"

namespace vesta::schema {

// Allowed range of a number, ends included. NaN is never in range.
struct Range {
  double min, max;
};

// An enum value and its name. An option of an enum type has an array of its choices.
template <class E>
struct Choice {
  E value;
  const char* name;
};

// A field with any non-empty text. placeholder: the word for the value in the help, such as FILE.
struct Words {
  const char* placeholder;
};

// Kind of value. kWhole: integer. kSwitch: true or false. kWords: any text.
enum class Kind { kWhole, kNumber, kSwitch, kChoice, kColor, kWords };

// Description of a field, independent of the struct's type.
struct FieldInfo {
  std::string name;  // name within the struct; "part.name" for a nested struct
  Kind kind;
  const char* help;
  const char* flag = nullptr;             // dedicated command-line flag, if any
  Range range = {};                       // kWhole, kNumber, and each channel of kColor
  std::vector<const char*> choices = {};  // kChoice
  const char* placeholder = "";           // kWords
  bool may_be_auto = false;               // whether "auto" is valid too: the value is then chosen from the data

  // The allowed values: "from 0 to 1".
  std::string Allowed() const;
  // For an error message: "it must be from 0 to 1".
  std::string Requirement() const;
  // The value in the help: N, X, a|b, R,G,B.
  std::string Placeholder() const;
};

// Formats a number so that parsing gives the same value.
std::string Print(double value);
std::string Print(Index value);
std::vector<std::string> SplitAt(const std::string& text, char separator);

// Returns at most max_count names with the smallest edit distance, nearest first. Omits very different names.
std::vector<std::string> Nearest(const std::string& name, const std::vector<std::string>& names,
                                 std::size_t max_count = 3);

// Whether all choices have distinct values and names.
template <class E, std::size_t N>
constexpr bool AreDistinct(const Choice<E> (&choices)[N]) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (choices[i].value == choices[j].value) return false;
      if (std::string_view(choices[i].name) == choices[j].name) return false;
    }
  }
  return true;
}

// Returns the name of the value, or "?" if it is not among the choices.
template <class E>
constexpr const char* NameOf(E value, std::span<const Choice<std::type_identity_t<E>>> choices) {
  for (const Choice<E>& choice : choices) {
    if (choice.value == value) return choice.name;
  }
  return "?";
}

// Prints, parses and checks values of type V. FromText returns false and leaves `value` unchanged if the text is not a
// number or out of range.
template <class V>
struct Numbers {
  using Wide = std::conditional_t<std::is_floating_point_v<V>, double, Index>;
  static constexpr Kind kKind = std::is_floating_point_v<V> ? Kind::kNumber : Kind::kWhole;
  static std::string ToText(V value) { return Print(static_cast<Wide>(value)); }
  static bool FromText(const std::string& text, Range range, V& value) {
    Wide wide{};
    if (!ParseNumber(text, &wide)) return false;
    if (!(static_cast<double>(wide) >= range.min && static_cast<double>(wide) <= range.max)) return false;
    value = static_cast<V>(wide);
    return true;
  }
};

template <class V>
struct Numbers<std::optional<V>> {
  static constexpr Kind kKind = Numbers<V>::kKind;
  static std::string ToText(const std::optional<V>& value) { return value ? Numbers<V>::ToText(*value) : "auto"; }
  static bool FromText(const std::string& text, Range range, std::optional<V>& value) {
    if (text == "auto") {
      value.reset();
      return true;
    }
    V number{};
    if (!Numbers<V>::FromText(text, range, number)) return false;
    value = number;
    return true;
  }
};

template <std::size_t N>
struct Numbers<std::array<double, N>> {
  static constexpr Kind kKind = Kind::kColor;
  static std::string ToText(const std::array<double, N>& value) {
    std::string text;
    for (const double channel : value) {
      if (!text.empty()) text += ',';
      text += Print(channel);
    }
    return text;
  }
  static bool FromText(const std::string& text, Range range, std::array<double, N>& value) {
    const std::vector<std::string> parts = SplitAt(text, ',');
    std::array<double, N> read{};
    if (parts.size() != N) return false;
    for (std::size_t i = 0; i < N; ++i) {
      if (!Numbers<double>::FromText(parts[i], range, read[i])) return false;
    }
    value = read;
    return true;
  }
};

template <class V>
constexpr bool kIsOptional = false;
template <class V>
constexpr bool kIsOptional<std::optional<V>> = true;

// A row of the table of struct O.
template <class O>
class Field : public FieldInfo {
 public:
  // A number within a range. A std::optional also accepts "auto"; an array of numbers is a colour.
  template <class C, class V>
  Field(const char* field_name, V C::*member, Range allowed_range, const char* help_text,
        const char* flag_name = nullptr)
      : FieldInfo{.name = field_name, .kind = Numbers<V>::kKind, .help = help_text, .flag = flag_name},
        print_([member](const O& o) { return Numbers<V>::ToText(o.*member); }),
        parse_([member, allowed_range](const std::string& text, O& o) {
          return Numbers<V>::FromText(text, allowed_range, o.*member);
        }) {
    range = allowed_range;
    may_be_auto = kIsOptional<V>;
  }
  // A value of an enum. A std::optional also accepts "auto".
  template <class C, class V, class E, std::size_t N>
  requires std::same_as<V, E> || std::same_as<V, std::optional<E>> Field(const char* field_name, V C::*member,
                                                                         const Choice<E> (&allowed)[N],
                                                                         const char* help_text,
                                                                         const char* flag_name = nullptr)
      : FieldInfo{.name = field_name, .kind = Kind::kChoice, .help = help_text, .flag = flag_name},
        print_([member, values = std::span(allowed)](const O& o) -> std::string {
          if constexpr (kIsOptional<V>) {
            return o.*member ? NameOf(*(o.*member), values) : "auto";
          } else {
            return NameOf(o.*member, values);
          }
        }),
        parse_([member, values = std::span(allowed)](const std::string& text, O& o) {
          if constexpr (kIsOptional<V>) {
            if (text == "auto") {
              (o.*member).reset();
              return true;
            }
          }
          for (const Choice<E>& choice : values) {
            if (text != choice.name) continue;
            o.*member = choice.value;
            return true;
          }
          return false;
        }) {
    for (const Choice<E>& choice : allowed) choices.push_back(choice.name);
    may_be_auto = kIsOptional<V>;
  }
  // A boolean switch.
  template <class C>
  Field(const char* field_name, bool C::*member, const char* help_text, const char* flag_name = nullptr)
      : FieldInfo{.name = field_name, .kind = Kind::kSwitch, .help = help_text, .flag = flag_name},
        print_([member](const O& o) { return o.*member ? "true" : "false"; }),
        parse_([member](const std::string& text, O& o) {
          if (text != "true" && text != "false") return false;
          o.*member = text == "true";
          return true;
        }) {}
  // A string from a list of choices.
  template <class C>
  Field(const char* field_name, std::string C::*member, const std::vector<const char*>& allowed, const char* help_text,
        const char* flag_name = nullptr)
      : FieldInfo{.name = field_name, .kind = Kind::kChoice, .help = help_text, .flag = flag_name, .choices = allowed},
        print_([member](const O& o) { return o.*member; }),
        parse_([member, allowed](const std::string& text, O& o) {
          if (std::find(allowed.begin(), allowed.end(), text) == allowed.end()) return false;
          o.*member = text;
          return true;
        }) {}
  // Any non-empty text.
  template <class C>
  Field(const char* field_name, std::string C::*member, Words words, const char* help_text,
        const char* flag_name = nullptr)
      : FieldInfo{.name = field_name, .kind = Kind::kWords, .help = help_text, .flag = flag_name},
        print_([member](const O& o) { return o.*member; }),
        parse_([member](const std::string& text, O& o) {
          if (!text.empty()) o.*member = text;
          return !text.empty();
        }) {
    placeholder = words.placeholder;
  }
  // A field of a nested struct.
  template <class C, class Part>
  Field(const std::string& part_name, Part C::*part, const Field<Part>& field)
      : FieldInfo(field),
        print_([part, field](const O& o) { return field.Text(o.*part); }),
        parse_([part, field](const std::string& text, O& o) { return field.Set(text, o.*part); }) {
    name = part_name + "." + field.name;
  }

  std::string Text(const O& options) const { return print_(options); }
  // Returns false and leaves `options` unchanged if the text is not a valid value.
  bool Set(const std::string& text, O& options) const { return parse_(text, options); }
  // Whether the value in `options` is valid for this field.
  bool IsValid(const O& options) const {
    O copy = options;
    return Set(Text(options), copy);
  }

 private:
  std::function<std::string(const O&)> print_;
  std::function<bool(const std::string&, O&)> parse_;
};

template <class O>
using Table = std::vector<Field<O>>;

// Returns null if the table has no field of that name.
template <class O>
const Field<O>* Find(const Table<O>& table, const std::string& name) {
  for (const Field<O>& field : table) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

template <class O>
std::vector<std::string> Names(const Table<O>& table) {
  std::vector<std::string> names;
  names.reserve(table.size());
  for (const Field<O>& field : table) names.push_back(field.name);
  return names;
}

}  // namespace vesta::schema
