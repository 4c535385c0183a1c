// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/find_photograph.h"

#include <algorithm>
#include <array>
#include <filesystem>
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

bool IsImage(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kExtensions = {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"};
  return std::ranges::find(kExtensions, Lower(file.extension().string())) != kExtensions.end();
}

}  // namespace

const PhotographFinder::Listing& PhotographFinder::List(const std::string& folder) {
  const auto [it, is_new] = listings_.try_emplace(folder);
  Listing& listing = it->second;
  if (!is_new) return listing;
  const auto add = [](Paths& paths, const std::string& key, const std::string& path) {
    const auto [known, added] = paths.emplace(Lower(key), path);
    if (!added) known->second.clear();
  };
  std::error_code error;
  for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    const fs::path& path = file->path();
    add(listing.by_name, path.filename().string(), path.string());
    if (IsImage(path)) add(listing.by_stem, path.stem().string(), path.string());
  }
  return listing;
}

std::string PhotographFinder::Find(const std::string& folder, const std::string& name) {
  const fs::path path = fs::path(folder) / name;
  if (FileExists(path.string())) return path.string();
  const Listing& listing = List(path.parent_path().string());
  const auto only = [](const Paths& paths, const std::string& key) {
    const auto found = paths.find(Lower(key));
    return found == paths.end() ? std::string() : found->second;
  };
  std::string found = only(listing.by_name, path.filename().string());
  if (found.empty()) found = only(listing.by_stem, path.stem().string());
  return found.empty() ? path.string() : found;
}

std::string WithSlashes(std::string name) {
  std::ranges::replace(name, '\\', '/');
  return name;
}

}  // namespace vesta::gs
