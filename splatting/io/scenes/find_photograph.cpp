// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/find_photograph.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

#include "kernels/core/files.h"

namespace vesta::gs {
namespace {

namespace fs = std::filesystem;

std::string Lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; });
  return text;
}

bool IsImageExtension(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kExtensions = {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"};
  return std::ranges::find(kExtensions, Lower(file.extension().string())) != kExtensions.end();
}

// The only file in the folder for which fits(file name) holds.
template <class Fits>
std::optional<fs::path> OnlyFile(const fs::path& folder, const Fits& fits) {
  std::optional<fs::path> only;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!fits(it->path().filename())) continue;
    if (only) return std::nullopt;
    only = it->path();
  }
  return only;
}

}  // namespace

std::string FindPhotograph(const std::string& folder, const std::string& name) {
  const fs::path path = fs::path(folder) / name;
  if (FileExists(path.string())) return path.string();
  const std::string file = Lower(path.filename().string()), stem = Lower(path.stem().string());
  auto found = OnlyFile(path.parent_path(), [&](const fs::path& other) { return Lower(other.string()) == file; });
  if (!found) {
    found = OnlyFile(path.parent_path(), [&](const fs::path& other) {
      return IsImageExtension(other) && Lower(other.stem().string()) == stem;
    });
  }
  return found ? found->string() : path.string();
}

std::string WithSlashes(std::string name) {
  std::ranges::replace(name, '\\', '/');
  return name;
}

}  // namespace vesta::gs
