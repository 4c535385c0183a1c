// vesta beside Ceres on bundle adjustments and pose graphs: how long each solver takes to come within 0.1 % of the best
// cost any of them finds. Each solve runs in a process of its own; the solvers of one problem take turns.
//
//   solver_vs_ceres [--data DIR_OF_BAL_FILES] [--pose_graphs DIR] [--generated CAMERASxPOINTSxTRACK,...]
//                   [--calibration VIEWSxCORNERS,...]
//                   [--threads 1,2] [--repeats N] [--seconds LIMIT] [--only PART_OF_PROBLEM] [--solvers NAME,...]
//                   [--json FILE] [--curves FILE]
//                   [--times N]
//
// Of N solves in a process (1) the last is timed. A small problem's first solve waits for pages and symbols.
// --curves writes problem, threads, solver, seconds, cost, inner iterations of each moment as CSV, for
// bench/solver_race/plot.py.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "bench/report.h"
#include "bench/solver_race/contenders.h"
#include "kernels/core/check.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/generate.h"

namespace vesta::bench {
namespace {

constexpr double kWithin = 1.001;

struct Race {
  std::string problem;
  int threads = 1;
  std::vector<Contender> contenders;
};

// What one solver did in one race: the median repeat by time, costs of all.
struct Outcome {
  std::string name;
  std::vector<Run> runs;
  double BestCost() const {
    double best = std::numeric_limits<double>::infinity();
    for (const Run& run : runs) {
      if (!run.failed) best = std::min(best, run.FinalCost());
    }
    return best;
  }
  double MedianSecondsTo(double cost) const {
    std::vector<double> seconds;
    for (const Run& run : runs) seconds.push_back(run.SecondsTo(cost));
    std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2), seconds.end());
    return seconds[seconds.size() / 2];
  }
};

std::vector<std::string> FilesOf(const std::string& folder, const std::string& extension) {
  std::vector<std::string> files;
  if (folder.empty()) return files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == extension) files.push_back(entry.path().string());
  }
  if (files.empty()) Fail("{}: holds no *{} file", folder, extension);
  std::sort(files.begin(), files.end());
  return files;
}

bundle::GenerateOptions Generated(const std::string& text) {
  bundle::GenerateOptions options;
  int cameras = 0, points = 0;
  if (std::sscanf(text.c_str(), "%dx%dx%lf", &cameras, &points, &options.mean_track) != 3) {
    Fail("--generated={}: write CAMERASxPOINTSxTRACK, as 100x10000x8", text);
  }
  options.num_cameras = cameras;
  options.num_points = points;
  return options;
}

std::vector<Outcome> Run(const Race& race, int repeats, int times) {
  std::vector<Outcome> outcomes;
  for (const Contender& contender : race.contenders) outcomes.push_back({contender.name, {}});
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      outcomes[i].runs.push_back(RunAlone(race.contenders[i], times));
      const bench::Run& run = outcomes[i].runs.back();
      std::fprintf(stderr, "%s, %d threads, %s: cost %.9e in %.3f s, %.0f MiB%s\n", race.problem.c_str(), race.threads,
                   outcomes[i].name.c_str(), run.FinalCost(), run.moments.empty() ? 0 : run.moments.back().seconds,
                   run.peak_mib, run.failed ? "  FAILED" : "");
    }
  }
  return outcomes;
}

// The least of the times of the solvers whose name passes.
template <class Passes>
double Fastest(const std::vector<Outcome>& outcomes, double cost, const Passes& passes) {
  double best = std::numeric_limits<double>::infinity();
  for (const Outcome& outcome : outcomes) {
    if (passes(outcome.name)) best = std::min(best, outcome.MedianSecondsTo(cost));
  }
  return best;
}

// What races differ in when they are judged.
enum class Sort { kBundle, kPoses, kCalibration };

void Tell(const Race& race, const std::vector<Outcome>& outcomes, Sort sort, double limit, Report& report,
          std::ostream* curves) {
  double best = std::numeric_limits<double>::infinity();
  for (const Outcome& outcome : outcomes) best = std::min(best, outcome.BestCost());
  // Where the best cost is 0 up to rounding, costs are measured relative to that of the start.
  double start = 0;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.runs.front().failed) start = std::max(start, outcome.runs.front().moments.front().cost);
  }
  const double zero = 1e-14 * start, goal = kWithin * best + zero;
  for (const Outcome& outcome : outcomes) {
    const bench::Run& run = outcome.runs.front();
    if (run.failed) continue;
    report.Add({{"problem", race.problem},
                {"threads", static_cast<double>(race.threads)},
                {"solver", outcome.name},
                {"s to 1.01", outcome.MedianSecondsTo(1.01 * best + zero)},
                {"s to 1.001", outcome.MedianSecondsTo(goal)},
                {"s to 1.00001", outcome.MedianSecondsTo(1.00001 * best + zero)},
                {"final cost", outcome.BestCost()},
                {"over best", (outcome.BestCost() - best) / (best + zero)},
                {"iterations", static_cast<double>(run.moments.size()) - 1},
                {"inner", run.moments.back().inner},
                {"s in all", run.moments.back().seconds},
                {"peak MiB", run.peak_mib}});
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
  const double ours = Fastest(outcomes, goal, [](const std::string& name) { return name == "vesta"; });
  const auto target = [&](const std::string& what, double theirs, double time, double times) {
    // A solver that did not get there took at least the whole time. If neither did, the ratio is unknown.
    if (std::isinf(time) && std::isinf(theirs)) return;
    const double ratio = std::min(theirs, limit) / std::min(time, limit);
    report.AddTarget(
        {fmt::format("{}, {} threads: {}", race.problem, race.threads, what), ratio, "x", times, ratio >= times});
  };
  if (sort == Sort::kCalibration) {
    target("the bridge against the best of Ceres", Fastest(outcomes, goal, starts("Ceres")),
           Fastest(outcomes, goal, starts("vesta bridge auto")), 1 / 1.1);
    return;
  }
  if (sort == Sort::kPoses) {
    target("vesta against CGNR", Fastest(outcomes, goal, starts("Ceres CGNR")), ours,
           race.problem == "sphere2500" ? 5 : 1);
  } else {
    target("vesta against CGNR and implicit ITERATIVE_SCHUR", Fastest(outcomes, goal, implicit), ours, 2);
  }
  target("vesta against the best of Ceres", Fastest(outcomes, goal, starts("Ceres")), ours, 1);
  target("the bridge against CGNR", Fastest(outcomes, goal, starts("Ceres CGNR")),
         Fastest(outcomes, goal, starts("vesta bridge")), 1);
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
    if (!curves) Fail("--curves={}: the file cannot be written", curves_path);
    curves << "problem,threads,solver,seconds,cost,inner\n";
  }
  const auto wanted = [&](const std::string& name) { return name.find(only) != std::string::npos; };
  for (const std::string& threads : SplitAtCommas(arguments.Flag("threads", "1,2"))) {
    const RaceOptions options{ParseCount("threads", threads), static_cast<double>(arguments.Count("seconds", 60))};
    const auto run = [&](const std::string& name, std::vector<Contender> contenders, Sort sort) {
      if (!solvers.empty()) {
        std::erase_if(contenders, [&](const Contender& contender) {
          return std::find(solvers.begin(), solvers.end(), contender.name) == solvers.end();
        });
      }
      const Race race{name, options.threads, std::move(contenders)};
      Tell(race, Run(race, repeats, times), sort, options.seconds, report, curves_path.empty() ? nullptr : &curves);
    };
    for (const std::string& path : FilesOf(arguments.Flag("data", ""), ".txt")) {
      const std::string name = std::filesystem::path(path).stem().string();
      if (!wanted(name)) continue;
      run(name, BundleContenders([path] { return bundle::ReadBal(path); }, options), Sort::kBundle);
    }
    for (const std::string& text : SplitAtCommas(arguments.Flag("generated", ""))) {
      const bundle::GenerateOptions generated = Generated(text);
      run("generated " + text, BundleContenders([generated] { return bundle::Generate(generated); }, options),
          Sort::kBundle);
    }
    for (const std::string& text : SplitAtCommas(arguments.Flag("calibration", ""))) {
      int views = 0, corners = 0;
      if (std::sscanf(text.c_str(), "%dx%d", &views, &corners) != 2 || views < 1 || corners < 1) {
        Fail("--calibration={}: write VIEWSxCORNERS, as 15x63", text);
      }
      run("calibration " + text, CalibrationContenders(views, corners, options), Sort::kCalibration);
    }
    for (const std::string& path : FilesOf(arguments.Flag("pose_graphs", ""), ".g2o")) {
      const std::string name = std::filesystem::path(path).stem().string();
      if (!wanted(name)) continue;
      run(name, PoseGraphContenders(path, options), Sort::kPoses);
    }
  }
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    return vesta::bench::Main(argc, argv);
  } catch (const vesta::Error& error) {
    std::fprintf(stderr, "solver_vs_ceres: %s\n", error.what());
    return 1;
  }
}
