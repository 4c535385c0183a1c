// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/nerf_split.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "kernels/core/check.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/scenes/find_photograph.h"

namespace vesta::gs {
namespace {

constexpr std::array kLists = {"train_filenames", "val_filenames", "test_filenames"};
enum List : std::size_t { kTrain, kValidation, kTest };

// Maps the name of each listed view to its list. present: which lists exist.
std::map<std::string, List> ReadLists(const nlohmann::json& top, const std::string& file,
                                      std::array<bool, 3>* present) {
  std::map<std::string, List> lists;
  for (const List list : {kTrain, kValidation, kTest}) {
    const auto it = top.find(kLists[list]);
    if (it == top.end() || it->is_null()) continue;
    if (!it->is_array()) Fail(kBadFile, "{}: {} is not an array of file names", file, kLists[list]);
    (*present)[list] = !it->empty();
    for (const nlohmann::json& name : *it) {
      if (!name.is_string()) Fail(kBadFile, "{}: {} is not an array of file names", file, kLists[list]);
      const auto [known, is_new] = lists.emplace(NameOfFilePath(WithSlashes(name.get<std::string>())), list);
      if (!is_new && known->second != list) {
        Fail(kBadFile, "{}: {} is in {} and in {}; remove it from one of them", file, Printable(known->first),
             kLists[known->second], kLists[list]);
      }
    }
  }
  return lists;
}

}  // namespace

void ApplySplitLists(const nlohmann::json& top, const std::string& file, Scene* scene) {
  std::array<bool, 3> present{};
  const std::map<std::string, List> lists = ReadLists(top, file, &present);
  if (lists.empty()) return;
  std::vector<View>& views = scene->views;
  for (const auto& listed : lists) {
    if (std::ranges::none_of(views, [&](const View& view) { return view.name == listed.first; })) {
      Fail(kBadFile, "{}: {} names {}, which is the file_path of no frame", file, kLists[listed.second],
           Printable(listed.first));
    }
  }
  const List test_list = present[kTest] ? kTest : kValidation;
  const std::size_t all = views.size();
  std::erase_if(views, [&](const View& view) {
    const auto it = lists.find(view.name);
    if (it == lists.end()) return present[kTrain];
    return it->second != kTrain && it->second != test_list;
  });
  for (View& view : views) {
    const auto it = lists.find(view.name);
    view.role = it != lists.end() && it->second == test_list ? ViewRole::kTest : ViewRole::kTraining;
  }
  scene->split = kLists[present[test_list] ? test_list : kTrain];
  if (views.size() == all) return;
  scene->notes.push_back(fmt::format("{} of {} frames are not used, because no list of file names in {} selects them",
                                     all - views.size(), all, file));
}

std::string NameOfFilePath(std::string file_path) {
  std::string extension = std::filesystem::path(file_path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c); });
  if (extension != ".png" && extension != ".jpg" && extension != ".jpeg") file_path += ".png";
  return std::filesystem::path(file_path).lexically_normal().string();
}

}  // namespace vesta::gs
