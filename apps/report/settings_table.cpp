// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/report/html.h"
#include "apps/report/page.h"
#include "apps/settings/train_settings.h"

namespace vesta::app {
namespace {

using Settings = std::map<std::string, std::string>;

// The settings of the preset alone; empty for an unknown preset or command.
Settings PresetSettings(const RunRecord& record) {
  const std::string preset = record.Text("preset"), name = record.Text("command");
  const CommandInfo* command = FindCommand(name.empty() ? "train" : name);
  const bool is_known = std::any_of(gs::Presets().begin(), gs::Presets().end(),
                                    [&](const gs::Preset& known) { return known.name == preset; });
  if (!command || !is_known) return {};
  const auto options = Flattened(OptionsJson(PresetOf(*command, preset)));
  return {options.begin(), options.end()};
}

std::string Value(const Settings& settings, const std::string& key) {
  const auto found = settings.find(key);
  return found == settings.end() ? "-" : found->second;
}

std::string Head(const Report& report) {
  std::string html = "<div class=\"wide\"><table><thead><tr><th>option</th>";
  for (const ReportedRun& run : report.runs)
    html += fmt::format("<th><bdi>{}</bdi></th>", Escape(run.source.record.name()));
  return html + "<th>preset</th></tr></thead><tbody>\n";
}

}  // namespace

std::string SettingsTable(const Report& report) {
  std::vector<std::string> keys;  // in the order of metrics.json
  std::vector<Settings> of_runs, of_presets;
  for (const ReportedRun& run : report.runs) {
    const auto options = run.source.record.Options();
    for (const auto& [key, value] : options) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
    of_runs.emplace_back(options.begin(), options.end());
    of_presets.push_back(PresetSettings(run.source.record));
  }
  std::string changed, same;
  for (const std::string& key : keys) {
    bool differs = false;
    std::string row = fmt::format("<tr><th>{}</th>", Escape(key));
    for (std::size_t i = 0; i < of_runs.size(); ++i) {
      const std::string value = Value(of_runs[i], key);
      differs |= value != Value(of_runs[0], key) || (!of_presets[i].empty() && value != Value(of_presets[i], key));
      row += fmt::format("<td>{}</td>", Escape(value));
    }
    row += fmt::format("<td class=\"mute\">{}</td></tr>\n", Escape(Value(of_presets[0], key)));
    (differs ? changed : same) += row;
  }
  std::string html = "<h2>Settings</h2>\n";
  html += changed.empty() ? "<p>All settings are as in the preset.</p>\n"
                          : Head(report) + changed + "</tbody></table></div>\n";
  if (!same.empty()) {
    html +=
        "<details><summary>All other settings</summary>\n" + Head(report) + same + "</tbody></table></div></details>\n";
  }
  return html;
}

}  // namespace vesta::app
