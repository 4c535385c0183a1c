// SPDX-License-Identifier: Apache-2.0
// pose_graph: reads a pose graph in the format of g2o, solves it, and writes the result.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/commands/least_squares.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "problems/pose_graph/certificate.h"
#include "problems/pose_graph/closure_check.h"
#include "problems/pose_graph/g2o_file.h"
#include "problems/pose_graph/robust.h"
#include "problems/pose_graph/solve.h"

namespace vesta::app {
namespace {

pose_graph::EdgeError ErrorOf(const Flags& flags) {
  using pose_graph::EdgeError;
  if (flags.certify && flags.error && *flags.error != EdgeError::kIsotropic)
    throw UsageError("--certify: needs isotropic errors; use --error=isotropic, or leave --error out");
  if (flags.certify && flags.loss != "none")
    throw UsageError(fmt::format("--certify: is not possible with --loss={}; leave one out", flags.loss));
  if (flags.robust && flags.loss != "none")
    throw UsageError(fmt::format("--robust: is not possible with --loss={}; leave one out", flags.loss));
  return flags.error.value_or(flags.certify ? EdgeError::kIsotropic : EdgeError::kG2o);
}

// The vertex ids of the edges that are not kept.
std::vector<std::pair<Index, Index>> RejectedEdges(const pose_graph::PoseGraph& graph, const std::vector<bool>& kept) {
  std::vector<std::pair<Index, Index>> rejected;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    const auto [from, to] = graph.edges[e];
    if (!kept[e])
      rejected.emplace_back(graph.ids[static_cast<std::size_t>(from)], graph.ids[static_cast<std::size_t>(to)]);
  }
  return rejected;
}

// A solution, and with --robust the rejected edges.
struct Result {
  pose_graph::PoseGraphSolution solution;
  Index num_closures = 0;
  std::vector<std::pair<Index, Index>> rejected = {};
};

// Solves the graph. With --robust, removes the rejected edges from it.
Result Solve(const Flags& flags, const pose_graph::PoseGraphSolveOptions& options, pose_graph::PoseGraph& graph) {
  const LmCallback callback = [&](const LmIteration& row) { return AfterIteration(row, flags.log_lm); };
  if (!flags.robust) return {SolvePoseGraph(graph, options, callback)};
  pose_graph::RobustSolution robust = SolveRobustPoseGraph(graph, {.solve = options}, callback);
  Result result{std::move(robust.solution), robust.num_closures, RejectedEdges(graph, robust.kept)};
  graph = WithEdges(graph, robust.kept);
  return result;
}

struct Counts {
  Index poses, landmarks, priors;
};

Counts CountsOf(const pose_graph::PoseGraph& graph) {
  const auto landmarks = static_cast<Index>(graph.landmarks.size());
  const Index priors = graph.world < 0 ? 0
                                       : std::count_if(graph.edges.begin(), graph.edges.end(),
                                                       [&](const auto& edge) { return edge.from == graph.world; });
  return {graph.num_poses() - landmarks - (graph.world < 0 ? 0 : 1), landmarks, priors};
}

std::string ToJson(const Flags& flags, const Result& result, const pose_graph::PoseGraph& graph,
                   const std::optional<pose_graph::Certificate>& certificate) {
  const pose_graph::PoseGraphSolution& solution = result.solution;
  const LmSummary& summary = solution.summary;
  const Counts counts = CountsOf(graph);
  nlohmann::ordered_json json = {{"poses", counts.poses},
                                 {"landmarks", counts.landmarks},
                                 {"priors", counts.priors},
                                 {"edges", graph.num_edges() - counts.priors},
                                 {"status", ToString(summary.status)},
                                 {"start", solution.starts_chordal ? "chordal" : "given"},
                                 {"initial_cost", summary.initial_cost},
                                 {"final_cost", summary.final_cost},
                                 {"start_seconds", solution.initialize_seconds},
                                 {"seconds", solution.initialize_seconds + summary.total_seconds},
                                 {"peak_memory_mib", PeakMemoryMib()},
                                 {"threads", NumThreads()}};
  if (certificate) json["lower_bound"] = certificate->lower_bound;
  if (flags.robust) {
    json["closures"] = result.num_closures;
    json["rejected"] = result.rejected;
  }
  json["history"] = HistoryOf(summary);
  return json.dump(1) + "\n";
}

void PrintRejected(const Result& result) {
  constexpr std::size_t kMost = 10;
  std::string text;
  for (std::size_t k = 0; k < std::min(kMost, result.rejected.size()); ++k) {
    text += fmt::format("{} {}-{}", k == 0 ? ":" : ",", result.rejected[k].first, result.rejected[k].second);
  }
  if (result.rejected.size() > kMost) text += ", ... (--json lists all)";
  Print("rejected {} of {} loop closures{}\n", result.rejected.size(), result.num_closures, text);
}

void PrintResult(const Flags& flags, const Result& result, const pose_graph::PoseGraph& graph,
                 const std::optional<pose_graph::Certificate>& certificate) {
  const pose_graph::PoseGraphSolution& solution = result.solution;
  for (const std::string& note : graph.notes) Print("{}\n", note);
  const Counts counts = CountsOf(graph);
  std::string more;
  if (counts.landmarks > 0) more += fmt::format("{} landmarks, ", counts.landmarks);
  if (counts.priors > 0) more += fmt::format("{} priors, ", counts.priors);
  Print("{} poses, {}{} edges, from {} poses\n{}\n", counts.poses, more, graph.num_edges() - counts.priors,
        solution.starts_chordal ? "chordal" : "the given", solution.summary.BriefReport());
  if (flags.robust) PrintRejected(result);
  if (certificate && certificate->is_optimal()) {
    Print("globally optimal: no poses have a cost lower by more than {:.1g} of it\n", certificate->gap());
  } else if (certificate) {
    Print("not proven optimal: no poses have a cost below {:.6g}, which is lower by {:.2g} of the cost\n",
          certificate->lower_bound, certificate->gap());
  }
  Print("wrote {}\n", flags.out);
}

}  // namespace

int RunPoseGraph(const CommandLine& line) {
  const Flags& flags = line.flags;
  const std::string& file = line.arguments[0];
  pose_graph::PoseGraphSolveOptions options;
  options.problem.error = ErrorOf(flags);
  options.problem.loss = LossOf(flags);
  options.initialize = flags.initialize;
  options.lm.max_iterations = flags.robust ? 1000 : 100;
  // The lower bound of a certificate is close only at the minimum itself.
  if (flags.certify) options.lm.function_tolerance = 1e-12;
  SetLimits(flags, options.lm);
  CheckOutputs(line);
  pose_graph::PoseGraph graph = pose_graph::ReadG2o(file, {.clip_indefinite = true});
  const bool has_priors = graph.world >= 0, has_landmarks = !graph.landmarks.empty();
  if (flags.robust && (has_priors || has_landmarks))
    Fail(kUnsupported, "{}: has {}, which --robust does not check; leave --robust out", file,
         has_priors ? "priors" : "landmarks");
  if (flags.certify && has_landmarks) Fail(kUnsupported, "{}: has landmarks; leave --certify out", file);
  if (flags.certify && graph.fixed.size() > 1)
    Fail(kUnsupported, "{}: fixes {}, but --certify needs a graph with at most one fixed pose", file,
         has_priors ? "poses, and has priors" : fmt::format("{} poses", graph.fixed.size()));
  CatchInterrupts();
  const Result result = Solve(flags, options, graph);
  const pose_graph::PoseGraphSolution& solution = result.solution;
  if (flags.log_lm) PrintText(stderr, fmt::format("{}", solution.summary.FullReport()));
  if (solution.summary.status == LmStatus::kNonFinite) Fail(kBadFile, "{}: {}", file, solution.summary.message);
  std::optional<pose_graph::Certificate> certificate;
  if (flags.certify && !Interrupted()) certificate = Certify(graph, solution.poses);
  graph.poses = solution.poses;
  WriteG2o(graph, flags.out);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, ToJson(flags, result, graph, certificate));
  PrintResult(flags, result, graph, certificate);
  return Interrupted() ? kInterruptedStatus : 0;
}

}  // namespace vesta::app
