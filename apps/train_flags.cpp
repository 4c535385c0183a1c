#include "apps/train_flags.h"

#include "apps/device.h"
#include "apps/flag_values.h"
#include "apps/flags.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::app {
namespace {

template <class Flag, class Option>
void Override(const char* name, const Flag& flag, Option* option) {
  if (IsSet(name)) *option = static_cast<Option>(flag);
}

void OverrideAdam(gs::TrainOptions* options) {
  Override("iterations", FLAGS_iterations, &options->adam.iterations);
  Override("switch", FLAGS_switch, &options->adam.switch_to_lm);
  Override("adam_metric", FLAGS_adam_metric, &options->adam.metric);
  Override("views_per_iteration", FLAGS_views_per_iteration, &options->adam.views_per_iteration);
  Override("rate_factor", FLAGS_rate_factor, &options->adam.rate_factor);
  Override("rate_decay", FLAGS_rate_decay, &options->adam.rate_decay);
  Override("rate_cooldown", FLAGS_rate_cooldown, &options->adam.cooldown);
  Override("average_part", FLAGS_average_part, &options->adam.average_part);
  Override("coarse_part", FLAGS_coarse_part, &options->adam.coarse_part);
  Override("max_gaussians", FLAGS_max_gaussians, &options->density.max_gaussians);
  Override("gradient_threshold", FLAGS_gradient_threshold, &options->density.gradient_threshold);
  Override("opacity_reset_every", FLAGS_opacity_reset_every, &options->density.opacity_reset_every);
  if (FLAGS_fixed_model) {
    options->density.enabled = false;
    options->adam.sh_band_every = 0;
  }
}

void OverrideLm(gs::LmOptions* lm) {
  Override("lm_iterations", FLAGS_lm_iterations, &lm->iterations);
  Override("lm_min_gain", FLAGS_lm_min_gain, &lm->min_gain);
  Override("pcg_iterations", FLAGS_pcg_iterations, &lm->pcg_iterations);
  Override("lm_batches", FLAGS_lm_batches, &lm->batches);
  Override("batch_size", FLAGS_batch_size, &lm->batch_size);
  Override("batch_choice", FLAGS_batch_choice, &lm->batch_choice);
  Override("merge_batches", FLAGS_merge_batches, &lm->merge_batches);
  Override("damping", FLAGS_damping, &lm->damping);
  Override("preconditioner", FLAGS_preconditioner, &lm->preconditioner);
  Override("preconditioner_damping", FLAGS_preconditioner_damping, &lm->preconditioner_damping);
  Override("pcg_start", FLAGS_pcg_start, &lm->pcg_start);
  Override("pcg_tolerance", FLAGS_pcg_tolerance, &lm->pcg_tolerance);
  Override("jacobian", FLAGS_jacobian, &lm->jacobian);
  Override("residual_sampling", FLAGS_residual_sampling, &lm->residual_sampling);
  Override("sampling_unit", FLAGS_sampling_unit, &lm->sampling_unit);
  Override("sample_gradient", FLAGS_sample_gradient, &lm->sample_gradient);
  Override("step_limit", FLAGS_step_limit, &lm->step_limit);
  Override("step_limit_size", FLAGS_step_limit_size, &lm->step_limit_size);
  Override("min_diagonal", FLAGS_min_diagonal, &lm->min_diagonal);
  Override("max_diagonal", FLAGS_max_diagonal, &lm->max_diagonal);
  Override("step_control", FLAGS_step_control, &lm->step_control);
  Override("line_search", FLAGS_line_search, &lm->line_search);
  Override("line_search_views", FLAGS_line_search_views, &lm->line_search_views);
  Override("initial_lambda", FLAGS_initial_lambda, &lm->initial_lambda);
  Override("min_lambda", FLAGS_min_lambda, &lm->min_lambda);
  Override("max_lambda", FLAGS_max_lambda, &lm->max_lambda);
  Override("rates_damping", FLAGS_rates_damping, &lm->rates_damping);
  Override("position_damping", FLAGS_position_damping, &lm->position_damping);
  Override("sh_damping", FLAGS_sh_damping, &lm->sh_damping);
  Override("view_agreement", FLAGS_view_agreement, &lm->view_agreement);
  Override("l1_floor", FLAGS_l1_floor, &lm->l1_floor);
  Override("loss_linearization", FLAGS_loss_linearization, &lm->loss_linearization);
  Override("huber_threshold", FLAGS_huber_threshold, &lm->huber_threshold);
  Override("ssim_linearization", FLAGS_ssim_linearization, &lm->ssim_linearization);
  Override("ssim_jacobian", FLAGS_ssim_jacobian, &lm->ssim_jacobian);
  Override("l1_weight", FLAGS_l1_weight, &lm->l1_weight);
  Override("ssim_weight", FLAGS_ssim_weight, &lm->ssim_weight);
}

}  // namespace

gs::TrainOptions WithTrainFlags(gs::TrainOptions options) {
  OverrideAdam(&options);
  OverrideLm(&options.lm);
  Override("sh_degree", FLAGS_sh_degree, &options.sh_degree);
  Override("seed", FLAGS_seed, &options.seed);
  Override("memory_budget", FLAGS_memory_budget, &options.memory.budget_gib);
  Override("time_limit", FLAGS_time_limit, &options.time_limit);
  gs::ValidateOptions(options);
  return options;
}

std::array<float, 3> BackgroundFromFlag() {
  std::array<float, 3> color{};
  VESTA_CHECK(ParseColor(FLAGS_background, &color), "--background={}", FLAGS_background);
  return color;
}

void UseComputeFlags() {
  CheckDeviceFlag();
  SetNumThreads(FLAGS_threads);
}

}  // namespace vesta::app
