// SPDX-License-Identifier: Apache-2.0
// The notes of a training: lines for the user about deviations from the options.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace vesta::gs {

// Formats for TrainingSession::Note. In most formats that end with ": {}", the last argument is an Error's message.
namespace notes {

inline constexpr char kEvaluatesSomeViews[] =
    "evaluations use {} of {} training views; set train.evaluated_views to use more";
inline constexpr char kMissesTarget[] =
    "{:.2f} dB on the held-out views, below the {:.2f} of --target_psnr; train longer, for example with --preset=best, "
    "or lower the target";
inline constexpr char kFewerGaussiansFit[] = "limited to {} Gaussians: the GPU has no memory for more";

inline constexpr char kCamerasChosen[] = "cameras.refine=auto chooses {}: {}";
inline constexpr char kCamerasByOlderCurvatures[] =
    "cameras without a current curvature use an older one, or do not move: {}";

inline constexpr char kScoringSkipped[] =
    "{} rounds of scoring Gaussians or SH coefficients were skipped: --time_limit={:g} leaves no time for them";
inline constexpr char kKeepsMoreThanAsked[] =
    "{} Gaussians remain, more than the {} of pruning.keep_fraction={}: the stage ended early";

inline constexpr char kAdamGoesBack[] = "Adam continues from iteration {} with {} Gaussians and adds no more: {}";
inline constexpr char kAdamEnds[] = "Adam ends after {} iterations: {}";
inline constexpr char kAdamOnCpu[] = "Adam runs on the CPU: {}";
inline constexpr char kAdamWithoutMean[] = "Adam returns its last parameters instead of their average: {}";

inline constexpr char kLmWithCamerasIsPlain[] =
    "LM with camera refinement uses all views as one batch, no cached Jacobian and no line search";
inline constexpr char kLmInFewerBatches[] = "LM uses {} of the lm.batches={} requested: there are {} training views";
inline constexpr char kLmLowersNothing[] =
    "LM has no training loss to minimise: lm.l1_weight and lm.ssim_weight are both 0";
inline constexpr char kLmEliminatesNothing[] = "LM does not eliminate the cameras: there is too little memory";
inline constexpr char kLmWithOtherJacobian[] = "LM uses lm.jacobian={} instead of {}";
inline constexpr char kLmGainsLittle[] =
    "LM ended after {} of {} iterations: the last one lowered the training loss by a fraction below "
    "lm.function_tolerance={:g}";
inline constexpr char kLmEnds[] = "LM ends after {} iterations: {}";
inline constexpr char kLmByOneView[] = "LM continues with one view at a time: {}";

}  // namespace notes

// Skips repeated notes, which a resumed training may add.
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
