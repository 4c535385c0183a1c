// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "bench/report.h"
#include "kernels/core/check.h"

namespace vesta::bench {

Curve MedianCurve(const std::vector<Curve>& repeats) {
  VESTA_CHECK(!repeats.empty(), "no repeats");
  Curve median = repeats.front();
  // With a time limit, repeats may end at different rows.
  for (const Curve& repeat : repeats) median.resize(std::min(median.size(), repeat.size()));
  std::vector<double> seconds(repeats.size());
  for (std::size_t i = 0; i < median.size(); ++i) {
    for (std::size_t r = 0; r < repeats.size(); ++r) {
      const gs::HistoryRow& row = repeats[r][i];
      // The row at the time limit has another iteration in each repeat.
      if (row.iteration != median[i].iteration && i + 1 == median.size()) {
        median.resize(i);
        return median;
      }
      VESTA_CHECK(row.stage == median[i].stage && row.iteration == median[i].iteration && row.cost == median[i].cost,
                  "row {} of one repeat is not that of another", i);
      seconds[r] = row.seconds;
    }
    median[i].seconds = Median(seconds);
  }
  return median;
}

double SecondsToCost(const Curve& curve, double cost) {
  for (const gs::HistoryRow& row : curve) {
    if (row.cost <= cost) return row.seconds;
  }
  return std::numeric_limits<double>::infinity();
}

double LowestCost(const Curve& curve) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const gs::HistoryRow& row : curve) lowest = std::min(lowest, row.cost);
  return lowest;
}

void WriteCsvHeader(std::ostream& out) {
  out << "scene,method,stage,iteration,seconds,cost,train_psnr,train_ssim,test_psnr,test_ssim,gaussians\n";
}

void WriteCsv(const std::string& scene, const std::string& method, const Curve& curve, std::ostream& out) {
  for (const gs::HistoryRow& row : curve) {
    out << fmt::format("{},{},{},{},{:.4f},{:.8f},{:.5f},{:.6f},{:.5f},{:.6f},{}\n", scene, method,
                       gs::StageName(row.stage), row.iteration, row.seconds, row.cost, row.train.psnr, row.train.ssim,
                       row.test.psnr, row.test.ssim, row.gaussians);
  }
}

}  // namespace vesta::bench
