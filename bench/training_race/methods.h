// SPDX-License-Identifier: Apache-2.0
// The methods that lm_vs_adam compares.
#pragma once

#include <string>
#include <vector>

#include "bench/report.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::bench {

enum class MethodKind {
  kOurs,  // Adam, then LM, with the options of the flags after "--"
  // vesta's LM stage alone, from the state at which kOurs begins it; runs all iterations, without function tolerance
  // and without gradient shrinkage
  kOurLm,
  kPublishedLm,  // a published LM stage, from the same state
  kAdam,         // Adam alone, one view per iteration
};

// True if the method is only an LM stage.
inline bool StartsAtLm(MethodKind kind) { return kind == MethodKind::kOurLm || kind == MethodKind::kPublishedLm; }

struct Method {
  std::string name;
  MethodKind kind;
  gs::TrainOptions options;
};

// Returns the methods whose group (ours, paper, adam) is in --methods; ours comes first. All have the same
// initialisation, densification, maximum number of Gaussians, background and seed as `ours`.
//
// paper: vesta's LM stage, and the LM stages of the 3DGS-LM paper and of its released code.
// adam: all combinations of --lengths (iterations) and --rate_factors, and the schedule of `ours`. Default lengths are
// 1, 2 and 4 times the Adam stage of `ours`, or 16 epochs of the training views if these are longer. Default factors
// are 1/2, 1 and 2 times the factor of `ours`. Throws Error for an invalid flag.
std::vector<Method> SelectMethods(const Arguments& arguments, const gs::TrainOptions& ours, int training_views);

}  // namespace vesta::bench
