// SPDX-License-Identifier: Apache-2.0
// Training curves: quality over training time.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "splatting/train/trainer.h"

namespace vesta::bench {

// Evaluations, in order of time.
using Curve = std::vector<gs::HistoryRow>;

// One curve for several repeats of a training, equal except for the times: each row has the median of the seconds, for
// an even number the upper one. Rows that a repeat lacks at its end are dropped. Throws Error without repeats, or if
// rows differ in stage, iteration or cost.
Curve MedianCurve(const std::vector<Curve>& repeats);

// Seconds of the first row with a training loss (HistoryRow::cost) of at most `cost`; infinity without one.
double SecondsToCost(const Curve& curve, double cost);

// The lowest training loss of all rows.
double LowestCost(const Curve& curve);

// A CSV file for bench/training_race/plot.py with the columns
// scene,method,stage,iteration,seconds,cost,train_psnr,train_ssim,test_psnr,test_ssim,gaussians.
void WriteCsvHeader(std::ostream& out);
void WriteCsv(const std::string& scene, const std::string& method, const Curve& curve, std::ostream& out);

}  // namespace vesta::bench
