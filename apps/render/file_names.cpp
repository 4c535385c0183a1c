// SPDX-License-Identifier: Apache-2.0
#include "apps/render/file_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace vesta::app {
namespace {

// A view's name as that of a file: folders become part of the name, with_extension keeps ".jpg" before ".png".
std::string FileName(const gs::View& view, bool with_extension) {
  std::string name = view.name;
  if (!with_extension) name = std::filesystem::path(name).replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name + ".png";
}

using Files = std::vector<std::string>;

// Adds them, unless one of them is there.
bool AddAll(const Files& files, std::set<std::string>* taken) {
  if (std::ranges::any_of(files, [&](const std::string& file) { return taken->contains(file); })) return false;
  taken->insert(files.begin(), files.end());
  return true;
}

}  // namespace

std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<Files(const std::string&)>& files_of) {
  std::vector<std::string> names;
  for (const bool with_extension : {false, true}) {
    names.clear();
    std::set<std::string> taken;
    bool are_different = true;
    for (const gs::View* view : views) {
      names.push_back(FileName(*view, with_extension));
      are_different = AddAll(files_of(names.back()), &taken) && are_different;
    }
    if (are_different) return names;
  }
  std::set<std::string> wanted, seen;  // by all, and by those before
  for (const std::string& name : names) {
    for (std::string& file : files_of(name)) wanted.insert(std::move(file));
  }
  for (std::string& name : names) {
    if (AddAll(files_of(name), &seen)) continue;
    const std::string stem = name.substr(0, name.rfind('.'));
    for (int number = 2;; ++number) {
      name = fmt::format("{}_{}.png", stem, number);
      if (AddAll(files_of(name), &wanted)) break;
    }
  }
  return names;
}

}  // namespace vesta::app
