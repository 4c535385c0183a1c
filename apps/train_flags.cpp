#include "apps/train_flags.h"

#include <fmt/format.h>

#include <optional>
#include <type_traits>

#include "apps/device.h"
#include "apps/flag_values.h"
#include "apps/flags.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::app {
namespace {

// visit(name, flag, option) for each flag that stands for an option; `options` is const or not.
template <class Options, class Visit>
void VisitAdam(Options& options, const Visit& visit) {
  visit("iterations", FLAGS_iterations, options.adam.iterations);
  visit("switch", FLAGS_switch, options.adam.switch_to_lm);
  visit("adam_metric", FLAGS_adam_metric, options.adam.metric);
  visit("views_per_iteration", FLAGS_views_per_iteration, options.adam.views_per_iteration);
  visit("rate_factor", FLAGS_rate_factor, options.adam.rate_factor);
  visit("rate_decay", FLAGS_rate_decay, options.adam.rate_decay);
  visit("rate_cooldown", FLAGS_rate_cooldown, options.adam.cooldown);
  visit("average_part", FLAGS_average_part, options.adam.average_part);
  visit("coarse_part", FLAGS_coarse_part, options.adam.coarse_part);
  visit("max_gaussians", FLAGS_max_gaussians, options.density.max_gaussians);
  visit("gradient_threshold", FLAGS_gradient_threshold, options.density.gradient_threshold);
  visit("opacity_reset_every", FLAGS_opacity_reset_every, options.density.opacity_reset_every);
}

template <class Options, class Visit>
void VisitLm(Options& lm, const Visit& visit) {
  visit("lm_iterations", FLAGS_lm_iterations, lm.iterations);
  visit("lm_min_gain", FLAGS_lm_min_gain, lm.min_gain);
  visit("pcg_iterations", FLAGS_pcg_iterations, lm.pcg_iterations);
  visit("lm_batches", FLAGS_lm_batches, lm.batches);
  visit("batch_size", FLAGS_batch_size, lm.batch_size);
  visit("batch_choice", FLAGS_batch_choice, lm.batch_choice);
  visit("merge_batches", FLAGS_merge_batches, lm.merge_batches);
  visit("damping", FLAGS_damping, lm.damping);
  visit("preconditioner", FLAGS_preconditioner, lm.preconditioner);
  visit("preconditioner_damping", FLAGS_preconditioner_damping, lm.preconditioner_damping);
  visit("pcg_start", FLAGS_pcg_start, lm.pcg_start);
  visit("pcg_tolerance", FLAGS_pcg_tolerance, lm.pcg_tolerance);
  visit("jacobian", FLAGS_jacobian, lm.jacobian);
  visit("residual_sampling", FLAGS_residual_sampling, lm.residual_sampling);
  visit("sampling_unit", FLAGS_sampling_unit, lm.sampling_unit);
  visit("sample_gradient", FLAGS_sample_gradient, lm.sample_gradient);
  visit("step_limit", FLAGS_step_limit, lm.step_limit);
  visit("step_limit_size", FLAGS_step_limit_size, lm.step_limit_size);
  visit("min_diagonal", FLAGS_min_diagonal, lm.min_diagonal);
  visit("max_diagonal", FLAGS_max_diagonal, lm.max_diagonal);
  visit("step_control", FLAGS_step_control, lm.step_control);
  visit("line_search", FLAGS_line_search, lm.line_search);
  visit("line_search_views", FLAGS_line_search_views, lm.line_search_views);
  visit("initial_lambda", FLAGS_initial_lambda, lm.initial_lambda);
  visit("min_lambda", FLAGS_min_lambda, lm.min_lambda);
  visit("max_lambda", FLAGS_max_lambda, lm.max_lambda);
  visit("rates_damping", FLAGS_rates_damping, lm.rates_damping);
  visit("position_damping", FLAGS_position_damping, lm.position_damping);
  visit("sh_damping", FLAGS_sh_damping, lm.sh_damping);
  visit("view_agreement", FLAGS_view_agreement, lm.view_agreement);
  visit("l1_floor", FLAGS_l1_floor, lm.l1_floor);
  visit("loss_linearization", FLAGS_loss_linearization, lm.loss_linearization);
  visit("huber_threshold", FLAGS_huber_threshold, lm.huber_threshold);
  visit("ssim_linearization", FLAGS_ssim_linearization, lm.ssim_linearization);
  visit("ssim_jacobian", FLAGS_ssim_jacobian, lm.ssim_jacobian);
  visit("l1_weight", FLAGS_l1_weight, lm.l1_weight);
  visit("ssim_weight", FLAGS_ssim_weight, lm.ssim_weight);
}

template <class Options, class Visit>
void VisitAll(Options& options, const Visit& visit) {
  VisitAdam(options, visit);
  VisitLm(options.lm, visit);
  visit("sh_degree", FLAGS_sh_degree, options.sh_degree);
  visit("seed", FLAGS_seed, options.seed);
  visit("memory_budget", FLAGS_memory_budget, options.memory.budget_gib);
  visit("time_limit", FLAGS_time_limit, options.time_limit);
}

template <class T>
std::string ValueText(const T& value) {
  if constexpr (std::is_same_v<T, std::optional<int>>) {
    return value ? fmt::format("{}", *value) : "";
  } else {
    return fmt::format("{}", value);
  }
}

}  // namespace

gs::TrainOptions WithTrainFlags(gs::TrainOptions options) {
  VisitAll(options, [](const char* name, const auto& flag, auto& option) {
    if (IsSet(name)) option = static_cast<std::remove_reference_t<decltype(option)>>(flag);
  });
  if (FLAGS_fixed_model) {
    options.density.enabled = false;
    options.adam.sh_band_every = 0;
  }
  gs::ValidateOptions(options);
  return options;
}

std::string OptionText(const gs::TrainOptions& options, const std::string& flag) {
  std::string text;
  VisitAll(options, [&](const char* name, const auto&, const auto& option) {
    if (name == flag) text = ValueText(option);
  });
  return text;
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
