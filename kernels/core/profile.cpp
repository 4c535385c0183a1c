// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/profile.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string_view>

namespace vesta {
namespace {

double Seconds(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

PhaseSeconds ReadClocks() { return {Seconds(CLOCK_MONOTONIC), Seconds(CLOCK_PROCESS_CPUTIME_ID)}; }

void Profile::AddElapsed() {
  const PhaseSeconds now = clock_();
  if (open_ >= 0) phases_[static_cast<std::size_t>(open_)].own += {now.wall - last_.wall, now.cpu - last_.cpu};
  last_ = now;
}

void Profile::Begin(const char* name) {
  AddElapsed();
  const auto found = std::ranges::find_if(
      phases_, [&](const Phase& phase) { return phase.parent == open_ && std::string_view(phase.name) == name; });
  const auto at = static_cast<int>(found - phases_.begin());
  if (found == phases_.end()) phases_.push_back({name, open_});
  open_ = at;
  ++phases_[static_cast<std::size_t>(at)].calls;
}

void Profile::End() {
  AddElapsed();
  open_ = phases_[static_cast<std::size_t>(open_)].parent;
}

std::vector<PhaseRow> Profile::Rows(double least_share) {
  AddElapsed();
  std::vector<PhaseRow> rows;
  if (phases_.empty()) return rows;
  std::vector<PhaseSeconds> whole(phases_.size());
  for (std::size_t i = phases_.size(); i-- > 0;) {
    whole[i] += phases_[i].own;
    if (phases_[i].parent >= 0) whole[static_cast<std::size_t>(phases_[i].parent)] += whole[i];
  }
  const auto add = [&](const auto& self, std::size_t at, int depth) -> void {
    rows.push_back({phases_[at].name, depth, phases_[at].calls, whole[at]});
    PhaseSeconds other = phases_[at].own;
    std::vector<std::size_t> children;
    for (std::size_t i = at + 1; i < phases_.size(); ++i) {
      if (phases_[i].parent != static_cast<int>(at)) continue;
      if (whole[i].wall < least_share * whole[0].wall) {
        other += whole[i];
      } else {
        children.push_back(i);
      }
    }
    if (children.empty()) return;
    std::ranges::stable_sort(children, [&](std::size_t a, std::size_t b) { return whole[a].wall > whole[b].wall; });
    for (const std::size_t child : children) self(self, child, depth + 1);
    rows.push_back({"other", depth + 1, 0, other});
  };
  add(add, 0, 0);
  return rows;
}

std::string ProfileTable(const std::vector<PhaseRow>& rows) {
  std::string text =
      fmt::format("{:<30} {:>8} {:>9} {:>6} {:>9} {:>6}\n", "phase", "calls", "wall s", "%", "CPU s", "cores");
  for (const PhaseRow& row : rows) {
    const PhaseSeconds& seconds = row.seconds;
    fmt::format_to(std::back_inserter(text), "{:<30} {:>8} {:>9.3f} {:>6.1f} {:>9.3f} {:>6.2f}\n",
                   std::string(2 * static_cast<std::size_t>(row.depth), ' ') + row.name,
                   row.calls > 0 ? fmt::format("{}", row.calls) : "", seconds.wall,
                   100 * seconds.wall / std::max(rows.front().seconds.wall, 1e-9), seconds.cpu,
                   seconds.cpu / std::max(seconds.wall, 1e-9));
  }
  return text;
}

}  // namespace vesta
