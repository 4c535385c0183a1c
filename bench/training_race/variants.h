// What lm_ablation changes, one thing at a time.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/train/options.h"

namespace vesta::bench {

struct Variant {
  std::string knob, name;
  gs::TrainOptions options;
  bool from_points = false;  // trains from the points; else LM alone, from the state where the reference begins it
};

// The reference first (knob "reference"), then small changes that ought to make none (knob "noise"), then all others.
// reference: its options; budget: how long its LM goes on, in times of its Adam stage.
std::vector<Variant> Variants(const gs::TrainOptions& reference, double budget);

}  // namespace vesta::bench
