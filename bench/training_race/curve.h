// SPDX-License-Identifier: Apache-2.0
// How a training went: its evaluations, in the order of time.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "splatting/train/trainer.h"

namespace vesta::bench {

using Curve = std::vector<gs::HistoryRow>;

// Repeats of one training, which differ in nothing but time: the rows that all of them have, each after the median of
// its seconds (of an even number the later one). Throws Error where repeats differ in more, or there is none.
Curve MedianCurve(const std::vector<Curve>& repeats);

// Seconds at the first row whose cost is at or below `cost`; infinity if there is none.
double SecondsToCost(const Curve& curve, double cost);

double LowestCost(const Curve& curve);

// "scene,method,stage,iteration,seconds,cost,train_psnr,train_ssim,test_psnr,test_ssim,gaussians" and rows of it, for
// bench/training_race/plot.py.
void WriteCsvHeader(std::ostream& out);
void WriteCsv(const std::string& scene, const std::string& method, const Curve& curve, std::ostream& out);

}  // namespace vesta::bench
