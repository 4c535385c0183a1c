// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "kernels/core/check.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {
namespace {

// No LM: Adam gained more per unit of work in all measurements (docs/decisions/lm-is-optional.md).
TrainOptions Balanced() { return {}; }

TrainOptions Fast() {
  TrainOptions options;
  options.adam.iterations_scale = 0.25;
  options.lm.gradient_shrinkage = 0;  // after a short Adam stage the views still agree on most of the gradient
  return options;
}

TrainOptions Best() {
  TrainOptions options;
  options.adam.iterations_scale = 2;
  options.density.grow_pull = 40;
  options.lm.function_tolerance = 0.001;
  return options;
}

// 3DGS-LM (Höllein et al. 2025): 20,000 iterations, densification until 15,000 (with our rule), then 5 LM
// iterations, each with 8 PCG iterations on up to 4 merged batches of 25 images, and a line search on 30 % of the
// images. Differences: docs/decisions/3dgs-lm-presets.md.
TrainOptions Paper() {
  TrainOptions options;
  AdamOptions& adam = options.adam;
  adam.iterations = 20000;
  adam.second_moment = SecondMoment::kDiagonal;
  adam.lr_scale = 1;
  adam.lr_final_ratio = 1;
  adam.averaging_fraction = 0;
  adam.half_resolution_until = 0;
  adam.sh_degree_interval = 0.05;
  options.pruning = PruningOptions::None();
  options.lr.opacity = 0.05;
  options.sh_degree = 3;
  DensityOptions& density = options.density;
  density.grow_pull = 15;
  density.begin = 0.025;
  density.every = 0.005;
  density.end = 0.75;
  density.opacity_reset_every = 0.15;
  density.prune_scale3d = 0.1;
  LmStageOptions& lm = options.lm;
  lm.iterations = 5;
  lm.function_tolerance = 0;
  lm.pcg_iterations = 8;
  lm.batches = 4;
  lm.batch_size = 25;
  lm.merge_batches = true;
  lm.damping = LmDamping::kDiagonal;
  lm.preconditioner = LmPreconditioner::kJacobi;
  lm.preconditioner_damping = PreconditionerDamping::kOne;
  lm.pcg_start = PcgStart::kPreconditioned;
  lm.pcg_tolerance = 1e-2;
  lm.damping_update = StepRule::k3dgsLmV2;
  lm.jacobian = JacobianKind::kCachedViews;
  lm.line_search = true;
  lm.initial_lambda = 1;
  lm.min_lambda = 1e-4;
  lm.max_lambda = 1e4;
  lm.gradient_shrinkage = 0;
  lm.min_diagonal = 2;  // for our JtJ; theirs is half of it, because our cost lacks the factor 1/2
  lm.loss_linearization = PixelLinearization::kSqrt;
  lm.ssim = SsimLinearization::kRootCenter;
  return options;
}

// The released code damps with D = diag(JtJ) clamped to [1, 1e6] and preconditions by the inverse of diag(JtJ) + D.
TrainOptions PaperCode() {
  TrainOptions options = Paper();
  LmStageOptions& lm = options.lm;
  lm.pcg_tolerance = 5e-2;
  lm.damping_update = StepRule::k3dgsLmCode;
  lm.max_diagonal = 2e6;
  lm.loss_linearization = PixelLinearization::kHuber;
  lm.l1_weight = 1;
  lm.ssim_weight = 0.25;
  return options;
}

}  // namespace

const std::vector<Preset>& Presets() {
  static const std::vector<Preset> presets = {
      {"fast", Fast}, {"balanced", Balanced}, {"best", Best}, {"paper", Paper}, {"paper_code", PaperCode}};
  return presets;
}

TrainOptions PresetOptions(const std::string& name) {
  std::string names;
  for (const Preset& preset : Presets()) {
    if (name == preset.name) return preset.options();
    names += (names.empty() ? "" : ", ") + std::string(preset.name);
  }
  Fail(kBadArgument, "--preset={}: it must be one of {}", name, names);
}

TrainOptions RefinePresetOptions(const std::string& name, std::optional<RefineMethod> method) {
  TrainOptions options = PresetOptions(name);
  options.density.enabled = false;
  options.pruning = PruningOptions::None();
  const bool is_paper = name == "paper" || name == "paper_code";
  const RefineMethod by = method.value_or(is_paper ? RefineMethod::kLm : RefineMethod::kViews);
  AdamOptions& adam = options.adam;
  // The model is complete: full size and all SH bands from the start.
  adam.half_resolution_until = adam.sh_degree_interval = 0;
  adam.iterations_scale *= 0.375;
  if (by == RefineMethod::kLm) adam.iterations = 0;
  if (is_paper) return options;
  options.lm.iterations = by == RefineMethod::kViews ? 0 : 12;
  options.lm.function_tolerance = 0.001;
  return options;
}

TrainOptions PrunePresetOptions(const std::string& name, std::optional<RefineMethod> method) {
  TrainOptions options = RefinePresetOptions(name, method);
  options.pruning = PruningOptions{};
  options.pruning.aic_weight = 0;  // the number to remove is set by other options
  options.pruning.begin = 0;
  options.pruning.end = 0.7;
  options.pruning.every = 0.05;
  return options;
}

}  // namespace vesta::gs
