// SPDX-License-Identifier: Apache-2.0
// Methods of Ceres that vesta does not have, or has as options: dogleg, nonmonotonic steps and inner iterations, each
// compared with plain Levenberg-Marquardt in Ceres itself. Solves NIST's regressions from both starts, the problems of
// More, Garbow and Hillstrom from 1, 10 and 100 times the standard start, and bundle adjustment files.
//
//   bench/ceres_methods [BAL_FILE ...] [--json FILE]
#include <ceres/ceres.h>
#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "bench/collections/more_garbow_hillstrom.h"
#include "bench/collections/nist.h"
#include "bench/report.h"
#include "bench/solver_race/snavely_error.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bench {
namespace {

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The cost and the processor time after each iteration, accepted or not.
struct Curve final : ceres::IterationCallback {
  struct Point {
    double cost, seconds;
  };
  std::vector<Point> points;
  double start = ProcessorSeconds();

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& row) override {
    points.push_back({row.cost, ProcessorSeconds() - start});
    return ceres::SOLVER_CONTINUE;
  }
  // The first iteration with a cost of at most `level`; the number of points if there is none.
  std::size_t Reaches(double level) const {
    const auto found = std::find_if(points.begin(), points.end(), [&](const Point& p) { return p.cost <= level; });
    return static_cast<std::size_t>(found - points.begin());
  }
};

// Solves a problem from its start with these options.
using Solve = std::function<void(ceres::Solver::Options& options)>;
struct Method {
  std::string name;
  std::function<void(ceres::Solver::Options& options)> choose;
};

// Solves all problems with all methods. A method solves a problem if its cost exceeds the least cost of all methods by
// at most this relative tolerance. Iterations and seconds count until then, over the problems that all methods solve.
void Compare(Report& report, const std::string& set, double tolerance, const std::vector<Method>& methods,
             const std::vector<Solve>& problems) {
  struct Total {
    double solved = 0, iterations = 0, seconds = 0, fewer = 0, more = 0;
  };
  std::vector<Total> totals(methods.size());
  double common = 0;
  for (const Solve& solve : problems) {
    std::vector<Curve> curves(methods.size());
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t m = 0; m < methods.size(); ++m) {
      ceres::Solver::Options options;
      options.logging_type = ceres::SILENT;
      options.callbacks.push_back(&curves[m]);
      methods[m].choose(options);
      curves[m].start = ProcessorSeconds();
      solve(options);
      for (const Curve::Point& point : curves[m].points) least = std::min(least, point.cost);
    }
    const double level = (1 + tolerance) * least + 1e-14 * curves[0].points.front().cost;
    std::vector<std::size_t> reached;
    bool all = true;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      reached.push_back(curves[m].Reaches(level));
      const bool solved = reached[m] < curves[m].points.size();
      totals[m].solved += solved;
      all = all && solved;
    }
    if (!all) continue;
    ++common;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      totals[m].iterations += static_cast<double>(reached[m]);
      totals[m].seconds += curves[m].points[reached[m]].seconds;
      totals[m].fewer += reached[m] < reached[0];
      totals[m].more += reached[m] > reached[0];
    }
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    report.Add({{"problems", set},
                {"method", methods[m].name},
                {"number", static_cast<double>(problems.size())},
                {"solved", totals[m].solved},
                {"by all", common},
                {"iterations", totals[m].iterations},
                {"fewer", totals[m].fewer},
                {"more", totals[m].more},
                {"seconds", totals[m].seconds}});
  }
}

Solve SmallSolve(const SmallProblem& small, std::vector<double> start) {
  return [&small, start = std::move(start)](ceres::Solver::Options& options) {
    std::vector<double> x = start;
    ceres::Problem problem;
    small.add_to(problem, nullptr, x.data());
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 2000;
    options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
  };
}

Solve BundleSolve(const bundle::BundleData& data) {
  return [&data](ceres::Solver::Options& options) {
    std::vector<double> x = data.x;
    double* const points = x.data() + data.num_cameras * bundle::kCameraSize;
    ceres::Problem problem;
    auto points_first = std::make_shared<ceres::ParameterBlockOrdering>();
    auto only_points = std::make_shared<ceres::ParameterBlockOrdering>();
    for (const bundle::Observation& seen : data.observations) {
      double* const camera = x.data() + seen.camera * bundle::kCameraSize;
      double* const point = points + seen.point * bundle::kPointSize;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<bundle::SnavelyError, 2, bundle::kCameraSize, bundle::kPointSize>(
              new bundle::SnavelyError{seen.pixel[0], seen.pixel[1]}),
          nullptr, camera, point);
      points_first->AddElementToGroup(point, 0);
      points_first->AddElementToGroup(camera, 1);
      only_points->AddElementToGroup(point, 0);
    }
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = points_first;
    if (options.use_inner_iterations) options.inner_iteration_ordering = only_points;
    options.max_num_iterations = 50;
    options.function_tolerance = 1e-9;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
  };
}

std::vector<Method> Methods(bool bundle) {
  using Options = ceres::Solver::Options;
  const auto dogleg = [](Options& options, ceres::DoglegType type) {
    options.trust_region_strategy_type = ceres::DOGLEG;
    options.dogleg_type = type;
  };
  std::vector<Method> methods = {
      {"LM", [](Options&) {}},
      {"LM, nonmonotonic", [](Options& options) { options.use_nonmonotonic_steps = true; }},
      {"dogleg", [=](Options& options) { dogleg(options, ceres::TRADITIONAL_DOGLEG); }},
      {"subspace dogleg", [=](Options& options) { dogleg(options, ceres::SUBSPACE_DOGLEG); }}};
  if (bundle)
    methods.push_back({"LM, inner iterations", [](Options& options) { options.use_inner_iterations = true; }});
  return methods;
}

void Run(const Arguments& arguments) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres logs non-finite residuals; the table shows the outcome
  Report report("ceres_methods");
  std::vector<Solve> problems;
  for (const nist::Regression& regression : nist::Regressions()) {
    for (const auto& start : {regression.data.start1, regression.data.start2}) {
      problems.push_back(SmallSolve(regression.problem, {start.begin(), start.end()}));
    }
  }
  Compare(report, "NIST", 1e-4, Methods(false), problems);
  for (const int factor : {1, 10, 100}) {
    problems.clear();
    for (const mgh::Formula& formula : mgh::Formulas()) {
      std::vector<double> start(formula.start.begin(), formula.start.end());
      for (double& value : start) value *= factor;
      problems.push_back(SmallSolve(formula.problem, std::move(start)));
    }
    Compare(report, fmt::format("More-Garbow-Hillstrom, {}x", factor), 1e-4, Methods(false), problems);
  }
  for (const std::string& path : arguments.positional) {
    const bundle::BundleData data = bundle::ReadBal(path);
    Compare(report, path.substr(path.rfind('/') + 1), 1e-2, Methods(true), {BundleSolve(data)});
  }
  report.Finish(arguments.Flag("json", ""));
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    vesta::bench::Run({argc, argv, {"json"}});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "ceres_methods: {}\n", error.what());
    return 1;
  }
}
