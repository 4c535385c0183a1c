// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/robust.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "kernels/core/check.h"
#include "problems/pose_graph/chordal.h"
#include "problems/pose_graph/closure_check.h"

namespace vesta::pose_graph {
namespace {

// r^T Lambda r of each edge.
std::vector<double> SquaredResiduals(PoseGraphProblem& problem, const std::vector<double>& poses) {
  std::vector<double> squares;
  const HostSpan<const double> x(poses.data(), static_cast<Index>(poses.size()));
  for (Index e = 0; e < problem.num_units(); ++e) squares.push_back(2 * problem.Cost(x, std::span(&e, 1)));
  return squares;
}

// Mean squared residual of the kept edges per degree of freedom.
double MeanSquare(const PoseGraph& graph, const std::vector<double>& squares, const std::vector<bool>& kept) {
  double sum = 0;
  Index num_edges = 0;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    if (!kept[e]) continue;
    sum += squares[e];
    ++num_edges;
  }
  const std::vector<bool> held = HeldPoses(graph);
  const Index free_poses = std::count(held.begin(), held.end(), false);
  const auto degrees = static_cast<double>(TangentSize(graph.space) * (num_edges - free_poses));
  return degrees > 0 ? sum / degrees : 1.0;
}

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

class TruncatedSolver {
 public:
  // begin: the time from which max_seconds counts.
  TruncatedSolver(const PoseGraph& graph, const RobustSolveOptions& options, const LmCallback& callback,
                  Clock::time_point begin)
      : graph_(graph),
        options_(options),
        callback_(callback),
        begin_(begin),
        iterations_left_(options.solve.lm.max_iterations),
        all_edges_(graph, options.solve.problem) {
    for (Index e = 0; e < graph.num_edges(); ++e) is_closure_.push_back(!IsOdometry(graph, e));
    quantile_ = ChiSquareQuantile(TangentSize(graph.space),
                                  options.significance / static_cast<double>(std::max<Index>(1, num_closures())));
  }

  Index num_closures() const { return std::count(is_closure_.begin(), is_closure_.end(), true); }

  // Solves the graph of the kept edges, and keeps the ones with residuals below the threshold, until they do not
  // change.
  RobustSolution Solve(std::vector<bool> kept) {
    constexpr int kMostSolves = 20;
    RobustSolution robust{.kept = std::move(kept), .num_closures = num_closures()};
    PoseGraph start = graph_;
    PoseGraphSolveOptions options = options_.solve;
    while (true) {
      options.lm.max_iterations = iterations_left_;
      options.lm.max_seconds = std::max(0.0, options_.solve.lm.max_seconds - SecondsSince(begin_));
      PoseGraphSolution next = SolvePoseGraph(WithEdges(start, robust.kept), options, callback_);
      if (robust.num_solves++ == 0) {
        robust.solution = std::move(next);
      } else {
        robust.solution.poses = std::move(next.poses);
        robust.solution.summary = std::move(next.summary);
      }
      iterations_left_ =
          std::max(0, iterations_left_ - robust.solution.summary.num_accepted - robust.solution.summary.num_rejected);
      const std::vector<double> squares = SquaredResiduals(all_edges_, robust.solution.poses);
      robust.information_scale = std::max(1.0, MeanSquare(graph_, squares, robust.kept));
      std::vector<bool> below(squares.size());
      for (std::size_t e = 0; e < below.size(); ++e) {
        below[e] = !is_closure_[e] || squares[e] <= quantile_ * robust.information_scale;
      }
      if (MustEnd(robust) || below == robust.kept || robust.num_solves == kMostSolves) break;
      robust.kept = std::move(below);
      start.poses = robust.solution.poses;
      start.has_poses = true;
      options.initialize = Initialize::kGiven;
    }
    robust.num_rejected = std::count(robust.kept.begin(), robust.kept.end(), false);
    return robust;
  }

  // Whether a limit, a failure or the callback ends all solves.
  bool MustEnd(const RobustSolution& robust) const {
    const LmStatus status = robust.solution.summary.status;
    return iterations_left_ == 0 || IsFailure(status) || status == LmStatus::kStoppedByCallback ||
           status == LmStatus::kTimeLimit;
  }

  // Whether `a` has a lower truncated cost than `b`. The threshold is the quantile times the smaller of their
  // mean squares. If the information is too small, this is closer to the noise than information_scale.
  bool IsBetter(const RobustSolution& a, const RobustSolution& b) {
    const std::vector<double> of_a = SquaredResiduals(all_edges_, a.solution.poses),
                              of_b = SquaredResiduals(all_edges_, b.solution.poses);
    const double threshold = quantile_ * std::min(MeanSquare(graph_, of_a, a.kept), MeanSquare(graph_, of_b, b.kept));
    const auto cost = [&](const std::vector<double>& squares) {
      double sum = 0;
      for (const double square : squares) sum += std::min(square, threshold);
      return sum;
    };
    return cost(of_a) < cost(of_b);
  }

 private:
  const PoseGraph& graph_;
  const RobustSolveOptions& options_;
  const LmCallback& callback_;
  Clock::time_point begin_;
  int iterations_left_;
  PoseGraphProblem all_edges_;
  std::vector<bool> is_closure_;
  double quantile_ = 0;
};

}  // namespace

RobustSolution SolveRobustPoseGraph(const PoseGraph& graph, const RobustSolveOptions& options,
                                    const LmCallback& callback) {
  if (options.solve.problem.loss) Fail(kBadArgument, "pose graph: a robust solve needs a problem without loss");
  if (graph.world >= 0 || !graph.landmarks.empty())
    Fail(kUnsupported, "pose graph: a robust solve needs a graph without landmarks and priors");
  const Clock::time_point begin = Clock::now();
  const ClosureCheck check = CheckClosures(graph, options.significance);
  TruncatedSolver solver(graph, options, callback, begin);
  RobustSolution best = solver.Solve(check.supported);
  if (check.likely != check.supported && check.likely != best.kept && !solver.MustEnd(best)) {
    RobustSolution other = solver.Solve(check.likely);
    const int num_solves = best.num_solves + other.num_solves;
    if (solver.IsBetter(other, best)) best = std::move(other);
    best.num_solves = num_solves;
  }
  best.solution.initialize_seconds = std::max(0.0, SecondsSince(begin) - best.solution.summary.total_seconds);
  return best;
}

}  // namespace vesta::pose_graph
