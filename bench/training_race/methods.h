// SPDX-License-Identifier: Apache-2.0
// The training methods of the benchmark lm_vs_adam.
#pragma once

#include <string>
#include <vector>

#include "bench/report.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::bench {

enum class MethodKind {
  kOurs,  // Adam, then LM, with the options after "--" on the command line
  // vesta's LM stage alone, from the splat with which the one of `ours` starts. It runs all iterations:
  // function_tolerance and gradient_shrinkage are 0
  kOurLm,
  kPublishedLm,  // published (3DGS-LM), from the same splat
  kAdam,         // Adam alone, one view per iteration
};

// Only an LM stage, without Adam.
inline bool StartsAtLm(MethodKind kind) { return kind == MethodKind::kOurLm || kind == MethodKind::kPublishedLm; }

struct Method {
  std::string name;
  MethodKind kind;
  gs::TrainOptions options;
};

// The methods of the groups in --methods (ours, paper, adam), `ours` first. All use the initialisation, densification,
// maximum number of Gaussians, background and seed of `ours`.
//
// * paper: LM stages only: vesta's (kOurLm), and the presets of the 3DGS-LM paper and of its released code.
// * adam: Adam only, at full resolution and with diagonal second moments: each number of iterations in --lengths with
//   each factor on the learning rates in --rate_factors, and the schedule of `ours`. The default lengths are N, 2 N and
//   4 N, where N is the number of iterations of `ours`, but at least 16 epochs (passes over the training views). The
//   default factors are 1/2, 1 and 2 times the factor of `ours`.
// Throws Error for an invalid flag.
std::vector<Method> SelectMethods(const Arguments& arguments, const gs::TrainOptions& ours, int training_views);

}  // namespace vesta::bench
