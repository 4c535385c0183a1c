// SPDX-License-Identifier: Apache-2.0
// The methods that lm_vs_adam compares.
#pragma once

#include <string>
#include <vector>

#include "bench/report.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::bench {

enum class MethodKind {
  kOurs,  // Adam, then LM, as the flags after "--" have it
  // our LM stage to its last iteration, whatever it gains, and by the whole gradient (lm.gradient_shrinkage 0),
  // from the state at which ours begins its own
  kOurLm,
  kPublishedLm,  // an LM stage as published, from the state at which ours begins its own
  kAdam,         // Adam alone, one view an iteration
};

// Whether it is an LM stage alone.
inline bool StartsAtLm(MethodKind kind) { return kind == MethodKind::kOurLm || kind == MethodKind::kPublishedLm; }

struct Method {
  std::string name;
  MethodKind kind;
  gs::TrainOptions options;
};

// The methods whose group (ours, paper, adam) is in --methods; ours comes first. All share
// initialisation, densification, cap, background and seed with `ours`.
//
// paper: the LM stages of the paper and of its released code, and ours.
// adam: --lengths x --rate_factors; unless given, 1, 2 and 4 times the longer of ours' own Adam stage and 16 epochs of
// the training views, and 1/2, 1 and 2 times ours' factor; and ours' own schedule beside them.
// Throws Error where a flag cannot be used.
std::vector<Method> SelectMethods(const Arguments& arguments, const gs::TrainOptions& ours, int training_views);

}  // namespace vesta::bench
