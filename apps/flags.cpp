#include "apps/flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gflags/gflags.h>

#include <algorithm>

// Numbers and choices of a training run come from the preset unless their flag is given: the defaults written here
// are never read for those.
DEFINE_string(out, "", "for the results: a folder, made if missing; of bundle_adjust a file");
DEFINE_string(json, "", "write the numbers to this file too");
DEFINE_bool(truth, false, "put the photograph to the right of each rendered image");

DEFINE_string(preset, "balanced",
              "where all other options start: lengths of ours, or the settings of 3DGS-LM's paper or code [balanced]");
DEFINE_int32(iterations, 0, "iterations of Adam; of bundle_adjust the most of Levenberg-Marquardt");
DEFINE_string(switch, "", "LM takes over after these, or sooner where it gains more for its work");
DEFINE_string(adam_metric, "", "what scales Adam's steps: all of a Gaussian's geometry, or each parameter alone");
DEFINE_int32(views_per_iteration, 1, "views whose mean gradient makes one iteration of Adam");
DEFINE_int64(max_gaussians, 0, "most Gaussians; of more points so many are taken");
DEFINE_bool(fixed_model, false, "no densification, all SH degrees from the start");
DEFINE_int32(sh_degree, 3, "degree of the colours' spherical harmonics (default: 2 below 24 training views, else 3)");
DEFINE_double(rate_factor, 0, "factor on Adam's learning rates");
DEFINE_double(rate_decay, 0, "part of the learning rates that is left at the end of Adam, but for the cooldown");
DEFINE_double(rate_cooldown, 0, "part of the Adam stage, at its end, in which they fall to 3 % of that; 0: none");
DEFINE_double(average_part, 0,
              "part of the Adam stage, at its end, that shows and leaves mean parameters; 0: the last ones");
DEFINE_double(coarse_part, 0, "part of the Adam stage, at its start, that sees images of half the size");
DEFINE_double(gradient_threshold, 0, "image-space gradient above which a Gaussian is cloned or split");
DEFINE_double(opacity_reset_every, 0, "part of the Adam stage between resets of opacity; 0: none");

DEFINE_int32(lm_iterations, 0, "most iterations of Levenberg-Marquardt, all views each");
DEFINE_double(lm_min_gain, 0, "end it where an iteration lowers the cost by a smaller part; 0: never");
DEFINE_int32(pcg_iterations, 0, "most conjugate-gradient iterations in each");
DEFINE_int32(lm_batches, 1, "parts into which the training views are divided");
DEFINE_bool(merge_batches, false, "solve batches one by one and merge their steps, instead of all in one");
DEFINE_string(damping, "", "metric of the damping: Adam's learning rates, or diag(JtJ)");
DEFINE_string(preconditioner, "", "11 x 11 blocks of JtJ, those and blocks of the colours, or its diagonal");
DEFINE_string(step_control, "",
              "rule for the damping: with backtracking, that of Ceres, of 3DGS-LM's paper (two), of its code");
DEFINE_bool(line_search, false, "search for the best length of each step");
DEFINE_double(line_search_views, 0, "part of the views on which it searches");
DEFINE_double(initial_lambda, 0, "damping at the start");
DEFINE_double(min_lambda, 0, "least damping");
DEFINE_double(max_lambda, 0, "most damping");
DEFINE_double(rates_damping, 0, "weight of the metric of learning rates");
DEFINE_double(position_damping, 0, "factor on it for the positions");
DEFINE_double(sh_damping, 0, "factor on it for the bands of the harmonics above the constant");
DEFINE_double(view_agreement, 0, "how strongly LM's gradients are shrunk where views disagree; 0: not");
DEFINE_double(l1_floor, 0, "errors below this count as squares in the reweighted L1");
DEFINE_string(jacobian, "",
              "products with J: from views held; from its entries in 32 or 16 bits; or from views built anew");
DEFINE_double(memory_budget, 0,
              "GiB that the program may take (of the GPU with one), foreseen before they are used; 0: no limit");
DEFINE_int32(batch_size, 0, "views in each part; 0: all views are divided");
DEFINE_string(batch_choice, "", "how views are dealt to parts: in order, by chance, or alike ones apart");
DEFINE_string(preconditioner_damping, "", "damping within the preconditioner: lambda, none, or one");
DEFINE_string(pcg_start, "", "where conjugate gradients start: at zero, or at the preconditioned gradient");
DEFINE_double(pcg_tolerance, 0, "residual at which they stop; 0: where the quadratic model hardly falls any more");
DEFINE_double(residual_sampling, 1, "part of the pixels of each view on which JtJ is measured");
DEFINE_string(sampling_unit, "", "how those are drawn: rows of each tile, or whole tiles");
DEFINE_bool(sample_gradient, false, "measure the gradient on those pixels too");
DEFINE_string(step_limit, "", "limit on the step of each parameter: caps by class, or the Hellinger distance");
DEFINE_double(step_limit_size, 1, "factor on the caps, or the squared Hellinger distance allowed");
DEFINE_double(min_diagonal, 0, "least diag(JtJ) in the damping; 0: a millionth of the median");
DEFINE_double(max_diagonal, 0, "most diag(JtJ) in the damping; 0: no limit");
DEFINE_string(loss_linearization, "", "LM's |error|: reweighted, as the square of its root, or Huber's, or its square");
DEFINE_double(huber_threshold, 0, "errors up to this count as squares with Huber's");
DEFINE_string(ssim_linearization, "", "LM's SSIM: a reweighted quadratic, or Gauss-Newton on the root of 1 - SSIM");
DEFINE_string(ssim_jacobian, "", "derivative of each window with the root: exact, or by its centre pixel alone");
DEFINE_double(l1_weight, 0, "weight of LM's |error|");
DEFINE_double(ssim_weight, 0, "weight of LM's 1 - SSIM");

DEFINE_string(background, "0,0,0", "colour behind everything, 0 to 1 (default: the .ply's, else 0,0,0)");
DEFINE_int32(downscale, 1, "divide the images' width and height by this");
DEFINE_uint64(seed, 0, "start of the random numbers");
DEFINE_int32(threads, 0, "threads; 0: one for each core");
DEFINE_double(time_limit, 0, "stop after so many seconds, loading included; 0: none");
DEFINE_string(device, "auto", "where to compute; auto: train and refine on a GPU where there is one");
DEFINE_string(loss, "none", "robust loss of each reprojection error, by its name in Ceres (default none)");
DEFINE_double(loss_scale, 1, "pixels from which an error counts less under --loss (default 1)");
DEFINE_bool(log_lm, false, "log each LM iteration, and the engine's report, to stderr");

namespace vesta::app {

const std::vector<CommandInfo>& Commands() {
  static const std::vector<CommandInfo> commands = {
      {kTrain, "train", {"SCENE"}, "train a splat from photographs with poses"},
      {kRefine, "refine", {"PLY", "SCENE"}, "improve a splat of any trainer's by Levenberg-Marquardt"},
      {kEval, "eval", {"PLY", "SCENE"}, "measure a splat on the training and test views"},
      {kRender, "render", {"PLY", "SCENE"}, "write images of the test views"},
      {kBundleAdjust, "bundle_adjust", {"FILE"}, "improve cameras and points of a BAL file", "FILE"},
  };
  return commands;
}

const CommandInfo* FindCommand(const std::string& name) {
  const auto& all = Commands();
  const auto found = std::find_if(all.begin(), all.end(), [&](const CommandInfo& c) { return c.name == name; });
  return found == all.end() ? nullptr : &*found;
}

const std::vector<FlagRule>& FlagRules() {
  constexpr unsigned kLm = kTrain | kRefine, kAll = kTrain | kRefine | kEval | kRender;
  constexpr double kMany = 1e9;
  static const std::vector<FlagRule> rules = {
      {"out", kTrain | kRefine | kRender | kBundleAdjust, Text{"DIR"}},
      {"json", kEval | kBundleAdjust, Text{"FILE"}},
      {"truth", kRender, Switch{}},
      {"preset", kLm, Choice{{"fast", "balanced", "best", "paper", "paper_code"}}},
      {"iterations", kTrain | kBundleAdjust, Range{0, kMany}},
      {"switch", kTrain, Choice{{"fixed", "auto"}}},
      {"adam_metric", kTrain, Choice{{"block", "diagonal"}}},
      {"views_per_iteration", kTrain, Range{1, kMany}},
      {"max_gaussians", kTrain, Range{1, kMany}},
      {"fixed_model", kTrain, Switch{}},
      {"sh_degree", kTrain, Range{0, 3}},
      {"rate_factor", kTrain, Range{1e-6, 1e6}},
      {"rate_decay", kTrain, Range{1e-6, 1}},
      {"rate_cooldown", kTrain, Range{0, 1}},
      {"average_part", kTrain, Range{0, 1}},
      {"coarse_part", kTrain, Range{0, 1}},
      {"gradient_threshold", kTrain, Range{0, kMany}},
      {"opacity_reset_every", kTrain, Range{0, 1}},
      {"lm_iterations", kLm, Range{0, kMany}},
      {"lm_min_gain", kLm, Range{0, 1}},
      {"pcg_iterations", kLm | kBundleAdjust, Range{1, kMany}},
      {"lm_batches", kLm, Range{1, kMany}},
      {"batch_size", kLm, Range{0, kMany}},
      {"batch_choice", kLm, Choice{{"strided", "random", "clustered"}}},
      {"merge_batches", kLm, Switch{}},
      {"damping", kLm, Choice{{"rates", "diag"}}},
      {"preconditioner", kLm, Choice{{"block", "block_sh", "jacobi"}}},
      {"preconditioner_damping", kLm, Choice{{"lambda", "none", "one"}}},
      {"pcg_start", kLm, Choice{{"zero", "preconditioned"}}},
      {"pcg_tolerance", kLm, Range{0, 1}},
      {"step_control", kLm, Choice{{"soft", "ceres", "v1", "v2", "code"}}},
      {"line_search", kLm, Switch{}},
      {"line_search_views", kLm, Range{1e-6, 1}},
      {"initial_lambda", kLm, Range{1e-30, 1e30}},
      {"min_lambda", kLm, Range{1e-30, 1e30}},
      {"max_lambda", kLm, Range{1e-30, 1e30}},
      {"rates_damping", kLm, Range{1e-30, 1e30}},
      {"position_damping", kLm, Range{1e-30, 1e30}},
      {"sh_damping", kLm, Range{1e-30, 1e30}},
      {"view_agreement", kLm, Range{0, 1e6}},
      {"l1_floor", kLm, Range{1e-6, 1}},
      {"jacobian", kLm, Choice{{"recompute", "cache32", "cache16", "rebuild"}}},
      {"memory_budget", kLm, Range{0, 1e6}},
      {"residual_sampling", kLm, Range{1e-3, 1}},
      {"sampling_unit", kLm, Choice{{"rows", "tiles"}}},
      {"sample_gradient", kLm, Switch{}},
      {"step_limit", kLm, Choice{{"none", "caps", "hellinger"}}},
      {"step_limit_size", kLm, Range{1e-12, 1e6}},
      {"min_diagonal", kLm, Range{0, 1e30}},
      {"max_diagonal", kLm, Range{0, 1e30}},
      {"loss_linearization", kLm, Choice{{"irls", "sqrt", "huber", "l2"}}},
      {"huber_threshold", kLm, Range{1e-6, 1e6}},
      {"ssim_linearization", kLm, Choice{{"quadratic", "root"}}},
      {"ssim_jacobian", kLm, Choice{{"exact", "center"}}},
      {"l1_weight", kLm, Range{0, 1e6}},
      {"ssim_weight", kLm, Range{0, 1e6}},
      {"background", kAll, Color{}},
      {"downscale", kAll, Range{1, 64}},
      {"seed", kLm, Range{0, 18446744073709551615.0}},
      {"time_limit", kLm | kBundleAdjust, Range{0, kMany}},
      {"threads", kAll | kBundleAdjust, Range{0, 1024}},
      {"device", kLm | kBundleAdjust, Choice{{"auto", "cpu", "cuda"}}},
      {"loss", kBundleAdjust, Choice{{"none", "huber", "soft_l1", "cauchy", "arctan", "tukey"}}},
      {"loss_scale", kBundleAdjust, Range{1e-6, kMany}},
      {"log_lm", kLm | kBundleAdjust, Switch{}},
  };
  return rules;
}

const FlagRule* FindFlag(const std::string& name) {
  const auto& all = FlagRules();
  const auto found = std::find_if(all.begin(), all.end(), [&](const FlagRule& rule) { return rule.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::string UsageForm(const CommandInfo& command) {
  const bool writes = FindFlag("out")->commands & command.command;
  return fmt::format("vesta {} {}{}{}", command.name, fmt::join(command.arguments, " "), writes ? " --out=" : "",
                     writes ? command.output : "");
}

bool IsSet(const char* name) { return !gflags::GetCommandLineFlagInfoOrDie(name).is_default; }

}  // namespace vesta::app
