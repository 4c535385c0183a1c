// SPDX-License-Identifier: Apache-2.0
// Solves a pose graph from the better of two starts.
#pragma once

#include <limits>
#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "problems/pose_graph/pose_graph_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::pose_graph {

enum class Initialize {
  kAuto,     // kGiven or kChordal, whichever has the lower cost
  kGiven,    // PoseGraph::poses, if the graph has poses
  kChordal,  // ChordalPoses (chordal.h); kGiven if its factor would be too large
};

struct PoseGraphSolveOptions {
  PoseGraphProblemOptions problem;
  LmOptions lm = PoseGraphOptions();
  Initialize initialize = Initialize::kAuto;
};

struct PoseGraphSolution {
  std::vector<double> poses;  // as PoseGraph::poses
  LmSummary summary;          // from the start that was used
  // Costs of the two starts; NaN for one that was not computed.
  double given_cost = std::numeric_limits<double>::quiet_NaN();
  double chordal_cost = std::numeric_limits<double>::quiet_NaN();
  bool starts_chordal = false;
  double initialize_seconds = 0;
};

// callback: see SolveLm. Throws Error as PoseGraphProblem does.
PoseGraphSolution SolvePoseGraph(const PoseGraph& graph, const PoseGraphSolveOptions& options = PoseGraphSolveOptions(),
                                 const LmCallback& callback = {});

}  // namespace vesta::pose_graph
