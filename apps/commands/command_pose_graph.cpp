// SPDX-License-Identifier: Apache-2.0
// pose_graph: reads a pose graph in the format of g2o, solves it, and writes the result.
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/commands/least_squares.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "problems/pose_graph/certificate.h"
#include "problems/pose_graph/g2o_file.h"
#include "problems/pose_graph/solve.h"

namespace vesta::app {
namespace {

pose_graph::EdgeError ErrorOf(const Flags& flags) {
  using pose_graph::EdgeError;
  if (flags.certify && flags.error && *flags.error != EdgeError::kIsotropic)
    throw UsageError("--certify: needs isotropic errors; use --error=isotropic, or leave --error out");
  if (flags.certify && flags.loss != "none")
    throw UsageError(fmt::format("--certify: is not possible with --loss={}; leave one out", flags.loss));
  return flags.error.value_or(flags.certify ? EdgeError::kIsotropic : EdgeError::kG2o);
}

std::string ToJson(const pose_graph::PoseGraphSolution& solution, const pose_graph::PoseGraph& graph,
                   const std::optional<pose_graph::Certificate>& certificate) {
  const LmSummary& summary = solution.summary;
  nlohmann::ordered_json json = {{"poses", graph.num_poses()},
                                 {"edges", graph.num_edges()},
                                 {"status", ToString(summary.status)},
                                 {"start", solution.starts_chordal ? "chordal" : "given"},
                                 {"initial_cost", summary.initial_cost},
                                 {"final_cost", summary.final_cost},
                                 {"start_seconds", solution.initialize_seconds},
                                 {"seconds", solution.initialize_seconds + summary.total_seconds},
                                 {"peak_memory_mib", PeakMemoryMib()},
                                 {"threads", NumThreads()}};
  if (certificate) json["lower_bound"] = certificate->lower_bound;
  json["history"] = HistoryOf(summary);
  return json.dump(1) + "\n";
}

void PrintResult(const Flags& flags, const pose_graph::PoseGraphSolution& solution, const pose_graph::PoseGraph& graph,
                 const std::optional<pose_graph::Certificate>& certificate) {
  for (const std::string& note : graph.notes) Print("{}\n", note);
  Print("{} poses, {} edges, from {} poses\n{}\n", graph.num_poses(), graph.num_edges(),
        solution.starts_chordal ? "chordal" : "the given", solution.summary.BriefReport());
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
  options.lm.max_iterations = 100;
  // The lower bound of a certificate is close only at the minimum itself.
  if (flags.certify) options.lm.function_tolerance = 1e-12;
  SetLimits(flags, options.lm);
  CheckOutputs(line);
  pose_graph::PoseGraph graph = pose_graph::ReadG2o(file, {.clip_indefinite = true});
  if (flags.certify && graph.fixed.size() > 1)
    Fail(kUnsupported, "{}: fixes {} poses, but --certify needs a graph with at most one", file, graph.fixed.size());
  CatchInterrupts();
  pose_graph::PoseGraphSolution solution =
      SolvePoseGraph(graph, options, [&](const LmIteration& row) { return AfterIteration(row, flags.log_lm); });
  if (flags.log_lm) PrintText(stderr, fmt::format("{}", solution.summary.FullReport()));
  if (solution.summary.status == LmStatus::kNonFinite) Fail(kBadFile, "{}: {}", file, solution.summary.message);
  std::optional<pose_graph::Certificate> certificate;
  if (flags.certify && !Interrupted()) certificate = Certify(graph, solution.poses);
  graph.poses = solution.poses;
  WriteG2o(graph, flags.out);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, ToJson(solution, graph, certificate));
  PrintResult(flags, solution, graph, certificate);
  return Interrupted() ? kInterruptedStatus : 0;
}

}  // namespace vesta::app
