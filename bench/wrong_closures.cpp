// SPDX-License-Identifier: Apache-2.0
// Adds wrong loop closures to pose graphs and compares the robust solve with the solution without them.
//
//   bench/wrong_closures FILE.g2o ... [--percents 0,10,20,30,50] [--seeds N] [--size EXTENTS] [--json FILE]
//
// percents: wrong closures relative to the true ones; size: of their positions (bench/collections/wrong_closures.h).
// Each row has, for all seeds, the largest difference to the positions of the solution without wrong closures, relative
// to the extent; the most true closures rejected and wrong ones kept; and the median of the time relative to the
// plain solve of the true graph.
#include "bench/collections/wrong_closures.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "bench/report.h"
#include "kernels/core/check.h"
#include "problems/pose_graph/closure_check.h"
#include "problems/pose_graph/g2o_file.h"
#include "problems/pose_graph/robust.h"

namespace vesta::bench {
namespace {

using pose_graph::PoseGraph;

template <class Body>
double SecondsOf(const Body& body) {
  const auto begin = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// One graph with the solution of its true closures.
struct Truth {
  std::string name;
  PoseGraph graph;  // its poses are the solution
  double extent = 0, seconds = 0;
};

Truth Solve(const std::string& path) {
  Truth truth{std::filesystem::path(path).stem().string(), pose_graph::ReadG2o(path, {.clip_indefinite = true})};
  truth.seconds = SecondsOf([&] { truth.graph.poses = SolvePoseGraph(truth.graph).poses; });
  truth.graph.has_poses = true;
  truth.extent = PositionExtent(truth.graph, truth.graph.poses);
  return truth;
}

Row Compare(const Truth& truth, int percent, int seeds, double size) {
  double difference = 0, closures = 0;
  Index rejected = 0, kept = 0;
  std::vector<double> ratios;
  for (int seed = 0; seed < seeds; ++seed) {
    const WrongClosures wrong{.fraction = percent / 100.0, .size = size, .seed = static_cast<std::uint64_t>(seed)};
    const PoseGraph graph = WithWrongClosures(truth.graph, wrong);
    pose_graph::RobustSolution robust;
    pose_graph::RobustSolveOptions options;
    options.solve.initialize = pose_graph::Initialize::kChordal;  // the poses of the solution must not help
    ratios.push_back(SecondsOf([&] { robust = SolveRobustPoseGraph(graph, options); }) / truth.seconds);
    const auto added = robust.kept.begin() + truth.graph.num_edges();
    difference =
        std::max(difference, PositionDifference(graph, robust.solution.poses, truth.graph.poses) / truth.extent);
    closures = static_cast<double>(robust.num_closures - (robust.kept.end() - added));
    rejected = std::max<Index>(rejected, std::count(robust.kept.begin(), added, false));
    kept = std::max<Index>(kept, std::count(added, robust.kept.end(), true));
  }
  return {{"graph", truth.name},
          {"true closures", closures},
          {"wrong, percent", static_cast<double>(percent)},
          {"largest difference / extent", difference},
          {"true ones rejected", static_cast<double>(rejected)},
          {"wrong ones kept", static_cast<double>(kept)},
          {"median time / plain", Median(ratios)}};
}

int Run(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"percents", "seeds", "size", "json"});
  if (arguments.positional.empty()) Fail(kBadArgument, "give at least one .g2o file");
  const double size = std::stod(arguments.Flag("size", "1"));
  Report report("wrong_closures");
  for (const std::string& path : arguments.positional) {
    const Truth truth = Solve(path);
    for (const std::string& percent : SplitAtCommas(arguments.Flag("percents", "0,10,20,30,50"))) {
      const bool is_clean = percent == "0";
      report.Add(Compare(truth, is_clean ? 0 : ParseCount("percents", percent),
                         is_clean ? 1 : arguments.Count("seeds", 3), size));
    }
  }
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("wrong_closures", vesta::bench::Run, argc, argv); }
