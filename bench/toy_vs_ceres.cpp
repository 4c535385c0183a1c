// SPDX-License-Identifier: Apache-2.0
// Solves small problems to the last digit with vesta and with Ceres's DENSE_QR: NIST's regressions from both starts,
// and the problems of More, Garbow and Hillstrom from 1, 10 and 100 times the standard start and with bounds.
//
//   bench/toy_vs_ceres [--json FILE]
#include <fmt/format.h>
#include <glog/logging.h>

#include "bench/collections/more_garbow_hillstrom.h"
#include "bench/collections/more_garbow_hillstrom_models.h"
#include "bench/collections/nist.h"
#include "bench/collections/solve_both.h"
#include "bench/report.h"

namespace vesta::bench {
namespace {

// Statistics of one group of solves: how many have four correct digits, and the most digits that vesta has fewer.
struct Tally {
  int solved = 0, solved_ceres = 0;
  double digits_behind = 0;

  void Count(double digits, double digits_ceres) {
    solved += digits >= 4;
    solved_ceres += digits_ceres >= 4;
    digits_behind = std::max(digits_behind, digits_ceres - digits);
  }
  void AddTarget(Report& report, const std::string& group) const {
    report.AddTarget({group + ": solved by vesta, goal Ceres's", static_cast<double>(solved), "problems",
                      static_cast<double>(solved_ceres), solved >= solved_ceres});
  }
};

void AddRow(Report& report, const std::string& problem, const std::string& start, const BothResults& both,
            double digits, double digits_ceres, Tally& tally) {
  tally.Count(digits, digits_ceres);
  report.Add({{"problem", problem},
              {"start", start},
              {"digits, vesta", digits},
              {"digits, Ceres", digits_ceres},
              {"sum of squares, vesta", 2 * both.cost},
              {"sum of squares, Ceres", 2 * both.cost_ceres},
              {"iterations, vesta", static_cast<double>(both.summary.iterations.size() - 1)},
              {"iterations, Ceres", static_cast<double>(both.iterations_ceres)}});
}

// Compares the parameters with the certified ones.
void Nist(Report& report) {
  Tally tally;
  for (const nist::Regression& regression : nist::Regressions()) {
    const nist::Problem& data = regression.data;
    for (const int start : {1, 2}) {
      const auto both = SolveBoth(regression.problem, start == 1 ? data.start1 : data.start2);
      AddRow(report, data.name, fmt::format("start {}", start), both, nist::Digits(both.x, data.certified),
             nist::Digits(both.x_ceres, data.certified), tally);
    }
  }
  tally.AddTarget(report, "NIST");
  report.AddTarget({"NIST: digits behind Ceres at worst", tally.digits_behind, "", 1, tally.digits_behind <= 1});
}

// Compares the sum of squares with the known minimum.
void MoreGarbowHillstrom(Report& report) {
  for (const int factor : {1, 10, 100}) {
    Tally tally;
    const std::string start = fmt::format("{}x", factor);
    for (const mgh::Formula& formula : mgh::Formulas()) {
      std::vector<double> x(formula.start.begin(), formula.start.end());
      for (double& value : x) value *= factor;
      const auto both = SolveBoth(formula.problem, x);
      AddRow(report, fmt::format("{} {}", formula.number, formula.name), start, both,
             mgh::Digits(2 * both.cost, formula.sum_of_squares),
             mgh::Digits(2 * both.cost_ceres, formula.sum_of_squares), tally);
    }
    tally.AddTarget(report, "More, Garbow, Hillstrom from " + start);
  }
}

void WithinBounds(Report& report) {
  Tally tally;
  for (const mgh::Formula& formula : mgh::Formulas()) {
    if (!formula.bounded()) continue;
    const auto both = SolveBoth(formula.problem, formula.start, nullptr, nullptr, formula.box);
    AddRow(report, fmt::format("{} {}", formula.number, formula.name), "1x, bounds", both,
           mgh::Digits(2 * both.cost, formula.bounded_sum_of_squares),
           mgh::Digits(2 * both.cost_ceres, formula.bounded_sum_of_squares), tally);
  }
  tally.AddTarget(report, "More, Garbow, Hillstrom within bounds");
}

void Run(const Arguments& arguments) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // the table shows non-finite residuals
  Report report("toy_vs_ceres");
  Nist(report);
  MoreGarbowHillstrom(report);
  WithinBounds(report);
  report.Finish(arguments.Flag("json", ""));
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) {
  try {
    vesta::bench::Run({argc, argv, {"json"}});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "toy_vs_ceres: {}\n", error.what());
    return 1;
  }
}
