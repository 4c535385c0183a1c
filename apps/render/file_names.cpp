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

}  // namespace

std::vector<std::string> FileNames(const std::vector<const gs::View*>& views) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const bool with_extension : {false, true}) {
    names.clear();
    for (const gs::View* view : views) names.push_back(FileName(*view, with_extension));
    taken = {names.begin(), names.end()};
    if (taken.size() == names.size()) return names;
  }
  std::set<std::string> seen;
  for (std::string& name : names) {
    const std::string stem = name.substr(0, name.rfind('.'));
    for (int number = 2; !seen.insert(name).second; ++number) {
      std::string numbered = fmt::format("{}_{}.png", stem, number);
      if (taken.insert(numbered).second) name = std::move(numbered);
    }
  }
  return names;
}

}  // namespace vesta::app
