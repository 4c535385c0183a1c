// SPDX-License-Identifier: Apache-2.0
// Compares vesta with Ceres on bundle adjustments and pose graphs: the time until each solver is within 0.1 % of the
// best cost of all. Each solve runs in its own process; the solvers of a problem take turns.
//
//   solver_vs_ceres [--data DIR_OF_BAL_FILES] [--pose_graphs DIR] [--generated CAMERASxPOINTSxTRACK,...]
//                   [--calibration VIEWSxCORNERS,...]
//                   [--threads 1,2] [--repeats N] [--seconds LIMIT] [--only PART_OF_PROBLEM] [--solvers NAME,...]
//                   [--json FILE] [--curves FILE]
//                   [--times N]
//
// --times: a process solves N times (default 1) and the last solve is timed. Page faults and symbol lookup slow down
// the first solve of a small problem.
// --curves writes CSV for bench/solver_race/plot.py: problem, threads, solver, seconds, cost and inner iterations of
// each moment.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>

#include "bench/collections/generate_bundle.h"
#include "bench/report.h"
#include "bench/solver_race/contenders.h"
#include "bench/solver_race/outcomes.h"
#include "kernels/core/check.h"
#include "problems/bundle_adjustment/bal_file.h"

namespace vesta::bench {
namespace {

constexpr double kWithin = 1.001;

bundle::GenerateOptions Generated(const std::string& text) {
  bundle::GenerateOptions options;
  int cameras = 0, points = 0;
  if (std::sscanf(text.c_str(), "%dx%dx%lf", &cameras, &points, &options.mean_track) != 3) {
    Fail(kBadArgument, "--generated={}: write CAMERASxPOINTSxTRACK, as 100x10000x8", text);
  }
  options.num_cameras = cameras;
  options.num_points = points;
  return options;
}

// The shortest time to this cost of the solvers whose name passes.
template <class Passes>
double Fastest(const std::vector<Outcome>& outcomes, double cost, const Passes& passes) {
  double best = std::numeric_limits<double>::infinity();
  for (const Outcome& outcome : outcomes) {
    if (passes(outcome.name)) best = std::min(best, outcome.MedianSecondsTo(cost));
  }
  return best;
}

// Kinds of problems, with different targets.
enum class Sort { kBundle, kPoses, kCalibration };

void Tell(const Race& race, const std::vector<Outcome>& outcomes, Sort sort, double limit, Report& report,
          std::ostream* curves) {
  const Goals goals = GoalsOf(outcomes);
  const double goal = goals.Within(kWithin);
  for (const Outcome& outcome : outcomes) {
    const Run& run = outcome.runs.front();
    if (run.failed) continue;
    Row row{{"problem", race.problem}, {"threads", static_cast<double>(race.threads)}, {"solver", outcome.name}};
    for (auto& figure : Figures(outcome, goals)) row.push_back(std::move(figure));
    report.Add(std::move(row));
    if (!curves) continue;
    for (const Moment& moment : run.moments) {
      *curves << fmt::format("{},{},{},{:.6f},{:.12e},{:.0f}\n", race.problem, race.threads, outcome.name,
                             moment.seconds, moment.cost, moment.inner);
    }
  }
  const auto starts = [](const std::string& begin) {
    return [begin](const std::string& name) { return name.rfind(begin, 0) == 0; };
  };
  const auto implicit = [](const std::string& name) {
    return name.rfind("Ceres CGNR", 0) == 0 ||
           (name.rfind("Ceres ITERATIVE", 0) == 0 && name.find("explicit") == std::string::npos);
  };
  const auto native = [](const std::string& name) { return name == "vesta"; };
  const auto target = [&](const std::string& what, const auto& theirs, const auto& mine, double times) {
    const auto races = [&](const auto& passes) {
      return std::any_of(outcomes.begin(), outcomes.end(),
                         [&](const Outcome& outcome) { return passes(outcome.name); });
    };
    if (!races(theirs) || !races(mine)) return;
    const double their_time = Fastest(outcomes, goal, theirs), my_time = Fastest(outcomes, goal, mine);
    // A solver that did not reach the goal counts with the time limit. If neither did, the ratio is unknown.
    if (std::isinf(my_time) && std::isinf(their_time)) return;
    const double ratio = std::min(their_time, limit) / std::min(my_time, limit);
    report.AddTarget(
        {fmt::format("{}, {} threads: {}", race.problem, race.threads, what), ratio, "x", times, ratio >= times});
  };
  if (sort == Sort::kCalibration) {
    target("the bridge against the best of Ceres", starts("Ceres"), starts("vesta bridge auto"), 1 / 1.1);
    return;
  }
  if (sort == Sort::kPoses) {
    target("vesta against CGNR", starts("Ceres CGNR"), native, race.problem == "sphere2500" ? 5 : 1);
  } else {
    target("vesta against CGNR and implicit ITERATIVE_SCHUR", implicit, native, 2);
  }
  target("vesta against the best of Ceres", starts("Ceres"), native, 1);
  target("the bridge against CGNR", starts("Ceres CGNR"), starts("vesta bridge"), 1);
}

int Main(int argc, char** argv) {
  const Arguments arguments(argc, argv,
                            {"data", "pose_graphs", "generated", "calibration", "threads", "repeats", "seconds", "only",
                             "solvers", "json", "curves", "times"});
  const int repeats = arguments.Count("repeats", 3), times = arguments.Count("times", 1);
  const std::string only = arguments.Flag("only", "");
  const std::vector<std::string> solvers = SplitAtCommas(arguments.Flag("solvers", ""));
  Report report("solver_vs_ceres");
  std::ofstream curves;
  const std::string curves_path = arguments.Flag("curves", "");
  if (!curves_path.empty()) {
    curves.open(curves_path);
    if (!curves) Fail(kCannotWrite, "--curves={}: the file cannot be written", curves_path);
    curves << "problem,threads,solver,seconds,cost,inner\n";
  }
  for (const std::string& threads : SplitAtCommas(arguments.Flag("threads", "1,2"))) {
    const RaceOptions options{ParseCount("threads", threads), static_cast<double>(arguments.Count("seconds", 60))};
    const auto run = [&](const std::string& name, std::vector<Contender> contenders, Sort sort) {
      if (!solvers.empty()) {
        std::erase_if(contenders, [&](const Contender& contender) {
          return std::find(solvers.begin(), solvers.end(), contender.name) == solvers.end();
        });
      }
      const Race race{name, options.threads, std::move(contenders)};
      Tell(race, RunRace(race, repeats, times), sort, options.seconds, report, curves_path.empty() ? nullptr : &curves);
    };
    for (const ProblemFile& file : FilesOf(arguments.Flag("data", ""), ".txt", only)) {
      run(file.name, BundleContenders([path = file.path] { return bundle::ReadBal(path); }, options), Sort::kBundle);
    }
    for (const std::string& text : SplitAtCommas(arguments.Flag("generated", ""))) {
      const bundle::GenerateOptions generated = Generated(text);
      run("generated " + text, BundleContenders([generated] { return bundle::Generate(generated); }, options),
          Sort::kBundle);
    }
    for (const std::string& text : SplitAtCommas(arguments.Flag("calibration", ""))) {
      int views = 0, corners = 0;
      if (std::sscanf(text.c_str(), "%dx%d", &views, &corners) != 2 || views < 1 || corners < 1) {
        Fail(kBadArgument, "--calibration={}: write VIEWSxCORNERS, as 15x63", text);
      }
      run("calibration " + text, CalibrationContenders(views, corners, options), Sort::kCalibration);
    }
    for (const ProblemFile& file : FilesOf(arguments.Flag("pose_graphs", ""), ".g2o", only)) {
      run(file.name, PoseGraphContenders(file.path, options), Sort::kPoses);
    }
  }
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  return vesta::bench::ReportErrors("solver_vs_ceres", vesta::bench::Main, argc, argv);
}
