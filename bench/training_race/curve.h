// SPDX-License-Identifier: Apache-2.0
// Training curves: quality over training time.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "splatting/train/trainer.h"

namespace vesta::bench {

// The evaluations of a training, in order of time.
using Curve = std::vector<gs::HistoryRow>;

// Returns one curve for several repeats of a training, which must be equal except for the times: each row has the
// median of the seconds, for an even number of repeats the upper one. Rows that a repeat lacks at its end are dropped.
// Throws Error without repeats, or if rows differ in stage, iteration or cost.
Curve MedianCurve(const std::vector<Curve>& repeats);

// Returns the seconds of the first row whose training loss (HistoryRow::cost) is at most `cost`; infinity if there is
// none.
double SecondsToCost(const Curve& curve, double cost);

// The lowest training loss of all rows.
double LowestCost(const Curve& curve);

// Write a CSV file for bench/training_race/plot.py with the columns
// scene,method,stage,iteration,seconds,cost,train_psnr,train_ssim,test_psnr,test_ssim,gaussians.
void WriteCsvHeader(std::ostream& out);
void WriteCsv(const std::string& scene, const std::string& method, const Curve& curve, std::ostream& out);

}  // namespace vesta::bench
