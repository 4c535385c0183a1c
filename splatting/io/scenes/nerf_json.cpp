// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/nerf_json.h"

#include <algorithm>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/span.h"

namespace vesta::gs {
namespace {

// An element of an array in the top-level object, for example frames[3].
struct Element {
  std::string key;  // of the array; empty outside of arrays
  Index index = 0;
};

// The element that contains this byte of the text, which is valid JSON up to there.
Element ElementAt(std::string_view text, std::size_t byte) {
  Element found;
  std::string last;  // the latest string; before '[' it is the key of the array
  int depth = 0;
  for (std::size_t i = 0; i < std::min(byte, text.size()); ++i) {
    const char c = text[i];
    if (c == '"') {
      const std::size_t begin = i + 1;
      for (++i; i < text.size() && text[i] != '"'; ++i) i += text[i] == '\\' ? 1 : 0;
      last = text.substr(begin, i - begin);
    } else if (c == '[' || c == '{') {
      if (++depth == 2 && c == '[') found = {last, 0};
    } else if (c == ']' || c == '}') {
      if (--depth == 1) found = {};
    } else if (c == ',' && depth == 2) {
      ++found.index;
    }
  }
  return found;
}

// byte: where the parser stopped.
[[noreturn]] void FailJson(const std::string& path, std::string_view text, std::size_t byte) {
  constexpr std::size_t kLongestWord = 8;
  const std::size_t begin = std::min(byte - std::min(byte, kLongestWord), text.size());
  const std::string_view near = text.substr(begin, 2 * kLongestWord);
  if (near.find("NaN") == near.npos && near.find("Inf") == near.npos) {
    Fail(kBadFile, "{}: not valid JSON at byte {}; copy or export it again", path, byte);
  }
  const Element at = ElementAt(text, byte);
  if (at.key == "frames" || at.key == "test_frames" || at.key == "camera_path") {
    const std::string name = at.key == "frames" ? "frame" : at.key;
    Fail(kBadFile, "{}: {} {}: a value is NaN or infinite; remove this element", path, name, at.index);
  }
  Fail(kBadFile, "{}: {}a value is NaN or infinite; correct it", path, at.key.empty() ? "" : Printable(at.key) + ": ");
}

}  // namespace

nlohmann::json ReadJson(const std::string& path) {
  const std::string text = ReadFile(path);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    FailJson(path, text, error.byte);
  } catch (const nlohmann::json::exception& error) {  // a number outside the range of double
    Fail(kBadFile, "{}: not valid JSON: {}", path, error.what());
  }
}

}  // namespace vesta::gs
