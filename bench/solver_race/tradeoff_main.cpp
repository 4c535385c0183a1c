// SPDX-License-Identifier: Apache-2.0
// Measures how inner tolerance, precision and preconditioner change the time until vesta is within 1 %, 0.1 % and
// 0.001 % of the best known cost, on bundle adjustments, pose graphs and NIST's regressions. Each solve runs in its own
// process; the choices of a problem take turns.
//
//   solver_tradeoff [--data DIR_OF_BAL_FILES] [--pose_graphs DIR] [--nist 1,2]
//                   [--threads N] [--repeats N] [--times N] [--seconds LIMIT] [--only PART_OF_PROBLEM]
//                   [--solvers PART_OF_NAME,...] [--json FILE] [--all_json FILE]
//
// --nist: starts of the regressions, 1 or 2 or both. --json writes the printed table: one row per choice and sort of
// problem, with the number of problems for which it reached each level, and the geometric mean of its time divided by
// the fastest choice's time on those problems. --all_json writes one row per choice and problem. --times: a process
// solves N times (default 1) and the last solve is timed; small problems need several.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "bench/report.h"
#include "bench/solver_race/choices.h"
#include "bench/solver_race/outcomes.h"
#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

constexpr double kWithin[] = {1.01, 1.001, 1.00001};

// Lowest known costs of problems whose minimum possibly no choice finds.
double KnownCost(const std::string& problem) {
  static const std::map<std::string, double> known{{"problem-49-7776-pre", 1.334425e4},
                                                   {"problem-21-11315-pre", 3.037864e4},
                                                   {"sphere2500", 6.757562e2},
                                                   {"sphere_bignoise_vertex3", 1.478348e6},
                                                   {"torus3D", 1.211352e4}};
  const auto found = known.find(problem);
  return found == known.end() ? std::numeric_limits<double>::infinity() : found->second;
}

// One choice over all problems of a sort.
struct Tally {
  // For each of kWithin.
  struct Level {
    int reached = 0;
    double log_ratio = 0;  // sum of the logs of its time / the fastest time
  };
  Row choice;
  int problems = 0;
  Level within[std::size(kWithin)] = {};
};

class Tradeoff {
 public:
  explicit Tradeoff(const Arguments& arguments)
      : race_{arguments.Count("threads", 2), static_cast<double>(arguments.Count("seconds", 20))},
        repeats_(arguments.Count("repeats", 3)),
        times_(arguments.Count("times", 1)),
        only_(arguments.Flag("only", "")),
        solvers_(SplitAtCommas(arguments.Flag("solvers", ""))) {}

  const RaceOptions& race() const { return race_; }
  const std::string& only() const { return only_; }
  bool Wants(const std::string& problem) const { return problem.find(only_) != std::string::npos; }

  void Run(const std::string& sort, const std::string& problem, double known, std::vector<Choice> choices) {
    if (!solvers_.empty()) {
      std::erase_if(choices, [&](const Choice& choice) {
        return std::none_of(solvers_.begin(), solvers_.end(),
                            [&](const std::string& part) { return choice.solver.find(part) != std::string::npos; });
      });
    }
    if (choices.empty()) Fail(kBadArgument, "--solvers: no solver of {} has such a name", problem);
    Race race{problem, race_.threads, {}};
    for (const Choice& choice : choices) race.contenders.push_back(choice.contender);
    const std::vector<Outcome> outcomes = RunRace(race, repeats_, times_);
    const Goals goals = GoalsOf(outcomes, known);
    for (std::size_t i = 0; i < choices.size(); ++i) {
      const Row choice{{"solver", choices[i].solver},
                       {"inner tolerance", choices[i].tolerance},
                       {"precision", choices[i].precision}};
      Row row{{"sort", sort}, {"problem", problem}, {"threads", static_cast<double>(race_.threads)}};
      row.insert(row.end(), choice.begin(), choice.end());
      for (auto& figure : Figures(outcomes[i], goals)) row.push_back(std::move(figure));
      // Does not depend on the load of the machine.
      const Moment* reached = outcomes[i].runs.front().FirstWithin(goals.Within(kWithin[1]));
      row.push_back({"inner to 1.001", reached ? reached->inner : std::numeric_limits<double>::infinity()});
      all_.Add(std::move(row));
      Count(sort, choice, outcomes, i, goals);
    }
  }

  void Finish(const std::string& json, const std::string& all_json) {
    all_.WriteJson(all_json);
    Report summary("solver_tradeoff");
    for (const auto& [sort, tallies] : tallies_) {
      for (const Tally& tally : tallies) {
        Row row{{"sort", sort}};
        row.insert(row.end(), tally.choice.begin(), tally.choice.end());
        row.push_back({"problems", static_cast<double>(tally.problems)});
        for (std::size_t k = 0; k < std::size(kWithin); ++k) {
          const auto& within = tally.within[k];
          row.push_back({fmt::format("reached {}", kWithin[k]), static_cast<double>(within.reached)});
          const double mean = within.reached > 0 ? std::exp(within.log_ratio / within.reached)
                                                 : std::numeric_limits<double>::infinity();
          row.push_back({fmt::format("x fastest to {}", kWithin[k]), mean});
        }
        summary.Add(std::move(row));
      }
    }
    summary.Finish(json);
  }

 private:
  void Count(const std::string& sort, const Row& choice, const std::vector<Outcome>& outcomes, std::size_t mine,
             const Goals& goals) {
    std::vector<Tally>& tallies = tallies_[sort];
    auto tally = std::find_if(tallies.begin(), tallies.end(), [&](const Tally& t) { return t.choice == choice; });
    if (tally == tallies.end()) tally = tallies.insert(tallies.end(), Tally{choice});
    ++tally->problems;
    for (std::size_t k = 0; k < std::size(kWithin); ++k) {
      const double goal = goals.Within(kWithin[k]), seconds = outcomes[mine].MedianSecondsTo(goal);
      if (std::isinf(seconds)) continue;
      double fastest = seconds;
      for (const Outcome& outcome : outcomes) fastest = std::min(fastest, outcome.MedianSecondsTo(goal));
      ++tally->within[k].reached;
      // If the starting cost is good enough, the time is 0.
      if (fastest > 0) tally->within[k].log_ratio += std::log(seconds / fastest);
    }
  }

  RaceOptions race_;
  int repeats_, times_;
  std::string only_;
  std::vector<std::string> solvers_;
  Report all_{"solver_tradeoff"};
  std::map<std::string, std::vector<Tally>> tallies_;
};

int Main(int argc, char** argv) {
  const Arguments arguments(
      argc, argv,
      {"data", "pose_graphs", "nist", "threads", "repeats", "times", "seconds", "only", "solvers", "json", "all_json"});
  Tradeoff tradeoff(arguments);
  for (const auto& [path, name] : FilesOf(arguments.Flag("data", ""), ".txt", tradeoff.only())) {
    tradeoff.Run("BAL", name, KnownCost(name), BundleChoices(path, tradeoff.race()));
  }
  for (const auto& [path, name] : FilesOf(arguments.Flag("pose_graphs", ""), ".g2o", tradeoff.only())) {
    tradeoff.Run("pose graphs", name, KnownCost(name), PoseGraphChoices(path, tradeoff.race()));
  }
  for (const std::string& start : SplitAtCommas(arguments.Flag("nist", ""))) {
    if (start != "1" && start != "2") Fail(kBadArgument, "--nist={}: choose 1, 2, or 1,2", start);
    for (SmallRace& race : NistChoices(start == "1" ? 1 : 2, tradeoff.race())) {
      if (tradeoff.Wants(race.problem)) tradeoff.Run("NIST", race.problem, race.known, std::move(race.choices));
    }
  }
  tradeoff.Finish(arguments.Flag("json", ""), arguments.Flag("all_json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  return vesta::bench::ReportErrors("solver_tradeoff", vesta::bench::Main, argc, argv);
}
