// SPDX-License-Identifier: Apache-2.0
// Measures automatic derivatives: one evaluation of a cost function with its Jacobians, by vesta's AutoDiffCost and by
// ceres::AutoDiffCostFunction, on one thread. The two alternate; times are medians.
//
//   autodiff [--rounds N] [--json FILE]
#include <ceres/autodiff_cost_function.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/report.h"
#include "bench/solver_race/snavely_error.h"
#include "kernels/core/error.h"
#include "solver/cost_function.h"

namespace vesta::bench {
namespace {

// Sums of exponentials, p[0] exp(-p[1] t) + p[2] exp(-p[3] t) + ..., at four times t: mostly exp.
template <int kParameters>
struct Exponentials {
  template <class T>
  bool operator()(const T* p, T* r) const {
    using std::exp;
    for (int j = 0; j < 4; ++j) {
      r[j] = T(-1.0);
      for (int i = 0; i < kParameters; i += 2) r[j] += p[i] * exp(p[i + 1] * T(-0.3 - j));
    }
    return true;
  }
};

// Four weighted sums over neighbours, as in Rosenbrock's function, without exp.
template <int kParameters>
struct Neighbours {
  template <class T>
  bool operator()(const T* p, T* r) const {
    for (int j = 0; j < 4; ++j) {
      r[j] = T(0.0);
      for (int i = 0; i + 1 < kParameters; ++i) {
        const T difference = p[i + 1] - p[i] * p[i];
        r[j] += difference * difference * T(1.0 + 0.1 * j) + p[i] * T(0.2);
      }
    }
    return true;
  }
};

// A cost function of either library with all its Jacobians.
template <class Cost>
class Evaluation {
 public:
  Evaluation(std::unique_ptr<Cost> cost, int num_residuals, const std::vector<int>& block_sizes)
      : cost_(std::move(cost)), residuals_(static_cast<std::size_t>(num_residuals)) {
    for (const int size : block_sizes) {
      std::vector<double>& values = parameters_.emplace_back();
      for (int i = 0; i < size; ++i) values.push_back(0.5 + 0.3 * std::sin(1.0 + i));
      jacobians_.emplace_back(residuals_.size() * values.size());
    }
    for (const auto& values : parameters_) parameter_pointers_.push_back(values.data());
    for (auto& jacobian : jacobians_) jacobian_pointers_.push_back(jacobian.data());
  }
  const std::vector<std::vector<double>>& jacobians() const { return jacobians_; }
  double Nanoseconds(int calls) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) Run();
    return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count() / calls;
  }

 private:
  void Run() {
    if (!cost_->Evaluate(parameter_pointers_.data(), residuals_.data(), jacobian_pointers_.data())) {
      throw Error(ErrorCode::kBadArgument, "the residuals are undefined");
    }
  }

  std::unique_ptr<Cost> cost_;
  std::vector<std::vector<double>> parameters_, jacobians_;
  std::vector<double> residuals_;
  std::vector<const double*> parameter_pointers_;
  std::vector<double*> jacobian_pointers_;
};

// Largest difference, relative to 1 + the absolute value.
double Difference(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b) {
  double worst = 0;
  for (std::size_t block = 0; block < a.size(); ++block) {
    for (std::size_t i = 0; i < a[block].size(); ++i) {
      worst = std::max(worst, std::abs(a[block][i] - b[block][i]) / (1 + std::abs(b[block][i])));
    }
  }
  return worst;
}

template <class F, int kResiduals, int... kBlocks>
void Measure(Report& report, int rounds, const std::string& name, const F& functor) {
  using Cost = AutoDiffCost<F, kResiduals, kBlocks...>;
  using CeresCost = ceres::AutoDiffCostFunction<F, kResiduals, kBlocks...>;
  Evaluation<Cost> ours(std::make_unique<Cost>(functor), kResiduals, {kBlocks...});
  Evaluation<CeresCost> theirs(std::make_unique<CeresCost>(new F(functor)), kResiduals, {kBlocks...});
  ours.Nanoseconds(1);
  // A round lasts about a millisecond.
  const int calls = 1 + static_cast<int>(1e6 / std::min(theirs.Nanoseconds(1), theirs.Nanoseconds(10)));
  std::vector<double> times, ceres_times, ratios;
  for (int round = 0; round < rounds; ++round) {
    times.push_back(ours.Nanoseconds(calls));
    ceres_times.push_back(theirs.Nanoseconds(calls));
    ratios.push_back(times.back() / ceres_times.back());
  }
  const double ratio = Median(ratios);
  report.Add({{"functor", name},
              {"parameters", static_cast<double>((kBlocks + ...))},
              {"residuals", static_cast<double>(kResiduals)},
              {"vesta ns", Median(times)},
              {"Ceres ns", Median(ceres_times)},
              {"ratio", ratio},
              {"largest difference", Difference(ours.jacobians(), theirs.jacobians())}});
  report.AddTarget(
      {fmt::format("{} of {} parameters: time of vesta / Ceres", name, (kBlocks + ...)), ratio, "", 1, ratio <= 1});
}

template <int kParameters>
void MeasureSums(Report& report, int rounds) {
  Measure<Exponentials<kParameters>, 4, kParameters>(report, rounds, "exponentials", {});
  Measure<Neighbours<kParameters>, 4, kParameters>(report, rounds, "neighbours", {});
}

int Run(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"rounds", "json"});
  const int rounds = arguments.Count("rounds", 101);
  Report report("autodiff");
  Measure<bundle::SnavelyError, 2, 9, 3>(report, rounds, "reprojection", {12, 34});
  MeasureSums<10>(report, rounds);
  MeasureSums<50>(report, rounds);
  MeasureSums<300>(report, rounds);
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("autodiff", vesta::bench::Run, argc, argv); }
