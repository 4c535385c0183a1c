// SPDX-License-Identifier: Apache-2.0
// Training curve: the evaluations of a training in order of time.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "splatting/train/trainer.h"

namespace vesta::bench {

using Curve = std::vector<gs::HistoryRow>;

// Combines repeats of one training, which must be identical except for the times. Returns the rows that all repeats
// have, with the median of the seconds (for an even number of repeats the upper median). Throws Error without repeats,
// or if they differ in stage, iteration or cost.
Curve MedianCurve(const std::vector<Curve>& repeats);

// Seconds of the first row with a cost of at most `cost`, or infinity.
double SecondsToCost(const Curve& curve, double cost);

double LowestCost(const Curve& curve);

// Write CSV for bench/training_race/plot.py with the columns
// scene,method,stage,iteration,seconds,cost,train_psnr,train_ssim,test_psnr,test_ssim,gaussians.
void WriteCsvHeader(std::ostream& out);
void WriteCsv(const std::string& scene, const std::string& method, const Curve& curve, std::ostream& out);

}  // namespace vesta::bench
