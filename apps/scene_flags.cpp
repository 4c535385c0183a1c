#include "apps/scene_flags.h"

#include <algorithm>
#include <filesystem>

namespace vesta::app {
namespace {

constexpr const char* kNames[] = {"images", "allow_missing", "test_every", "test_list"};

// Null where it is no flag of scenes.
const schema::Field<Flags>* FindSceneFlag(const std::string& name) {
  if (std::ranges::find(kNames, name) == std::end(kNames)) return nullptr;
  for (const FlagRow& row : ProgramFlags().after_options) {
    if (row.field.name == name) return &row.field;
  }
  return nullptr;
}

bool IsGiven(const schema::Field<Flags>& flag, const Flags& flags) { return flag.Text(flags) != flag.Text(Flags()); }

}  // namespace

void UseSceneFlags(const Flags& flags, gs::LoadSceneOptions* options) {
  if (flags.test_every && !flags.test_list.empty()) {
    throw UsageError("--test_every and --test_list: give only one of them");
  }
  options->image_folder = flags.images;
  options->allow_missing = flags.allow_missing;
  options->test_views = {.every = flags.test_every, .list = flags.test_list};
}

std::vector<std::pair<std::string, std::string>> SceneFlagTexts(const Flags& flags) {
  Flags elsewhere = flags;
  if (!flags.test_list.empty()) elsewhere.test_list = std::filesystem::absolute(flags.test_list).string();
  std::vector<std::pair<std::string, std::string>> texts;
  for (const char* name : kNames) {
    const schema::Field<Flags>* flag = FindSceneFlag(name);
    if (IsGiven(*flag, elsewhere)) texts.emplace_back(name, flag->Text(elsewhere));
  }
  return texts;
}

bool RestoreSceneFlag(const std::string& name, const std::string& value, Flags* flags) {
  const schema::Field<Flags>* flag = FindSceneFlag(name);
  if (!flag) return false;
  Flags scratch;
  if (!flag->Set(value, scratch)) return false;
  return IsGiven(*flag, *flags) || flag->Set(value, *flags);
}

}  // namespace vesta::app
