// SPDX-License-Identifier: Apache-2.0
#include "bench/solver_race/outcomes.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "kernels/core/check.h"

namespace vesta::bench {

double Outcome::BestCost() const {
  double best = std::numeric_limits<double>::infinity();
  for (const Run& run : runs) {
    if (!run.failed) best = std::min(best, run.FinalCost());
  }
  return best;
}

double Outcome::MedianSecondsTo(double cost) const {
  std::vector<double> seconds;
  for (const Run& run : runs) seconds.push_back(run.SecondsTo(cost));
  return Median(std::move(seconds));
}

std::vector<Outcome> RunRace(const Race& race, int repeats, int times) {
  std::vector<Outcome> outcomes;
  for (const Contender& contender : race.contenders) outcomes.push_back({contender.name, {}});
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      outcomes[i].runs.push_back(RunAlone(race.contenders[i], times));
      const Run& run = outcomes[i].runs.back();
      std::fprintf(stderr, "%s, %d threads, %s: cost %.9e in %.3f s, %.0f MiB%s\n", race.problem.c_str(), race.threads,
                   outcomes[i].name.c_str(), run.FinalCost(), run.moments.empty() ? 0 : run.moments.back().seconds,
                   run.peak_mib, run.failed ? "  FAILED" : "");
    }
  }
  return outcomes;
}

Goals GoalsOf(const std::vector<Outcome>& outcomes, double known) {
  double best = known, start = 0;
  for (const Outcome& outcome : outcomes) {
    best = std::min(best, outcome.BestCost());
    if (!outcome.runs.front().failed) start = std::max(start, outcome.runs.front().moments.front().cost);
  }
  return {best, 1e-14 * start};
}

Row Figures(const Outcome& outcome, const Goals& goals) {
  const Run& run = outcome.runs.front();
  const Moment last = run.moments.empty() ? Moment{} : run.moments.back();
  return {{"s to 1.01", outcome.MedianSecondsTo(goals.Within(1.01))},
          {"s to 1.001", outcome.MedianSecondsTo(goals.Within(1.001))},
          {"s to 1.00001", outcome.MedianSecondsTo(goals.Within(1.00001))},
          {"final cost", outcome.BestCost()},
          {"over best", (outcome.BestCost() - goals.best) / (goals.best + goals.zero)},
          {"iterations", std::max(0.0, static_cast<double>(run.moments.size()) - 1)},
          {"inner", last.inner},
          {"s in all", last.seconds},
          {"peak MiB", run.peak_mib}};
}

std::vector<ProblemFile> FilesOf(const std::string& folder, const std::string& extension, const std::string& part) {
  std::vector<ProblemFile> files;
  if (folder.empty()) return files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() != extension) continue;
    files.push_back({entry.path().string(), entry.path().stem().string()});
  }
  if (files.empty()) Fail(kNotFound, "{}: contains no *{} file", folder, extension);
  std::erase_if(files, [&](const ProblemFile& file) { return file.name.find(part) == std::string::npos; });
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

}  // namespace vesta::bench
