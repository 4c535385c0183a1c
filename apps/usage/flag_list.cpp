// SPDX-License-Identifier: Apache-2.0
#include "apps/usage/flag_list.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "apps/settings/train_settings.h"

namespace vesta::app {
namespace {

// Of the flags that set options, those that few need.
constexpr std::string_view kRareFlags[] = {"low_pass"};

}  // namespace

std::vector<ListedFlag> FlagsOf(const CommandInfo& command) {
  std::vector<ListedFlag> flags;
  const auto add_own = [&](const std::vector<FlagRow>& rows) {
    for (const FlagRow& row : rows) {
      if (!(row.commands & command.command)) continue;
      const std::string value = row.field.name == "preset" ? kDefaultPreset : row.field.Text(Flags());
      flags.push_back(
          {row.field.name, &row.field, value, (row.rare_for & command.command) != 0, row.if_bare != nullptr});
    }
  };
  add_own(ProgramFlags().before_options);
  for (ListedFlag option : OptionsOf(command)) {
    if (!option.field->flag) continue;
    option.name = option.field->flag;
    option.only_in_all = std::ranges::find(kRareFlags, option.name) != std::end(kRareFlags);
    flags.push_back(std::move(option));
  }
  add_own(ProgramFlags().after_options);
  return flags;
}

std::vector<ListedFlag> OptionsOf(const CommandInfo& command) {
  std::vector<ListedFlag> options;
  const gs::TrainOptions defaults = PresetOf(command, kDefaultPreset);
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    if (TakesOption(command, field)) options.push_back({field.name, &field, field.Text(defaults)});
  }
  return options;
}

}  // namespace vesta::app
