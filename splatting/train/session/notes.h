// SPDX-License-Identifier: Apache-2.0
// The notes of a training: one line for each deviation from the options. All texts are here.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace vesta::gs {

// Formats for TrainingSession::Note. In some, the last argument is the message of an Error.
namespace notes {

inline constexpr char kEvaluatesSomeViews[] =
    "evaluations look at {} of {} training views; at more by train.evaluated_views";
inline constexpr char kMissesTarget[] =
    "{:.2f} dB on the views held out, not the {:.2f} of --target_psnr; give it longer, as by --preset=best, or a lower "
    "target";
inline constexpr char kFewerGaussiansFit[] = "at most {} Gaussians: the GPU has no room for more";

inline constexpr char kCamerasChosen[] = "cameras.refine=auto chooses {}: {}";
inline constexpr char kCamerasByOlderCurvatures[] =
    "cameras are stepped by older curvatures, or stay where there is none: {}";

inline constexpr char kScoringSkipped[] =
    "{} rounds of judging Gaussians or harmonics were left out: --time_limit={:g} has no time for them";
inline constexpr char kKeepsMoreThanAsked[] =
    "{} Gaussians are left, not the {} of pruning.keep_fraction={}: the stage ended before";

inline constexpr char kAdamGoesBack[] = "Adam goes on from iteration {} with {} Gaussians and no more: {}";
inline constexpr char kAdamEnds[] = "Adam ends after {} iterations: {}";
inline constexpr char kAdamOnCpu[] = "Adam runs on the CPU: {}";
inline constexpr char kAdamWithoutMean[] = "Adam leaves its last parameters, not their mean: {}";

inline constexpr char kLmWithCamerasIsPlain[] =
    "LM that finds cameras takes all views as one batch, caches no Jacobian and searches no line";
inline constexpr char kLmInFewerBatches[] = "LM in {} of the lm.batches={} asked for: there are {} training views";
inline constexpr char kLmLowersNothing[] = "LM has nothing to lower: lm.l1_weight and lm.ssim_weight are both 0";
inline constexpr char kLmEliminatesNothing[] =
    "LM solves for cameras along with the splats: there is no room to eliminate them";
inline constexpr char kLmWithOtherJacobian[] = "LM with lm.jacobian={} in place of {}";
inline constexpr char kLmGainsLittle[] =
    "LM ended after {} of {} iterations: the last one lowered the cost by less than lm.function_tolerance={:g} of it";
inline constexpr char kLmEnds[] = "LM ends after {} iterations: {}";
inline constexpr char kLmByOneView[] = "LM goes on with one view at a time: {}";

}  // namespace notes

// The notes so far, without duplicates: a resumed training may add one again.
class TrainingNotes {
 public:
  void Add(std::string line) {
    if (std::ranges::find(lines_, line) == lines_.end()) lines_.push_back(std::move(line));
  }
  const std::vector<std::string>& lines() const { return lines_; }
  // Restores the notes of a resumed training.
  void Restore(std::vector<std::string> lines) { lines_ = std::move(lines); }
  std::vector<std::string> Take() { return std::move(lines_); }

 private:
  std::vector<std::string> lines_;
};

}  // namespace vesta::gs
