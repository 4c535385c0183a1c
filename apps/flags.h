// The program's flags, and which command takes which.
#pragma once

#include <gflags/gflags_declare.h>

#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

// clang-format off
DECLARE_string(out); DECLARE_string(json); DECLARE_bool(truth);
DECLARE_string(preset); DECLARE_int32(iterations); DECLARE_string(switch); DECLARE_string(adam_metric); DECLARE_int32(views_per_iteration); DECLARE_int64(max_gaussians); DECLARE_bool(fixed_model);
DECLARE_int32(sh_degree); DECLARE_double(rate_factor); DECLARE_double(rate_decay); DECLARE_double(rate_cooldown);
DECLARE_double(average_part); DECLARE_double(coarse_part);
DECLARE_double(gradient_threshold); DECLARE_double(opacity_reset_every);
DECLARE_int32(lm_iterations); DECLARE_double(lm_min_gain); DECLARE_int32(pcg_iterations); DECLARE_int32(lm_batches); DECLARE_bool(merge_batches);
DECLARE_string(damping); DECLARE_string(preconditioner); DECLARE_string(step_control); DECLARE_bool(line_search);
DECLARE_double(line_search_views); DECLARE_double(initial_lambda); DECLARE_double(min_lambda);
DECLARE_double(max_lambda); DECLARE_double(rates_damping); DECLARE_double(position_damping); DECLARE_double(sh_damping); DECLARE_double(view_agreement); DECLARE_double(l1_floor); DECLARE_string(jacobian);
DECLARE_int32(batch_size); DECLARE_string(batch_choice); DECLARE_string(preconditioner_damping);
DECLARE_string(pcg_start); DECLARE_double(pcg_tolerance); DECLARE_double(residual_sampling);
DECLARE_string(sampling_unit); DECLARE_bool(sample_gradient); DECLARE_string(step_limit); DECLARE_double(step_limit_size);
DECLARE_double(memory_budget); DECLARE_double(min_diagonal); DECLARE_double(max_diagonal);
DECLARE_string(loss_linearization); DECLARE_double(huber_threshold); DECLARE_string(ssim_linearization);
DECLARE_string(ssim_jacobian); DECLARE_double(l1_weight); DECLARE_double(ssim_weight);
DECLARE_string(background); DECLARE_int32(downscale); DECLARE_uint64(seed); DECLARE_int32(threads);
DECLARE_double(time_limit); DECLARE_string(device); DECLARE_bool(log_lm); DECLARE_string(loss);
DECLARE_double(loss_scale);
// clang-format on

namespace vesta::app {

// A command line that cannot be understood. what() is one line that says what to do.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum Command : unsigned { kTrain = 1, kRefine = 2, kEval = 4, kRender = 8, kBundleAdjust = 16 };

struct CommandInfo {
  Command command;
  const char* name;
  std::vector<const char*> arguments;  // positional, all required
  const char* summary;
  const char* output = "DIR";  // what --out names, where the command takes it
};
const std::vector<CommandInfo>& Commands();
// Null where there is none of that name.
const CommandInfo* FindCommand(const std::string& name);

// What a flag's value may be, apart from its type.
struct Range {
  double min, max;  // inclusive
};
struct Choice {
  std::vector<const char*> names;
};
struct Color {};  // R,G,B in 0..1
struct Switch {};
struct Text {
  const char* placeholder;
};

struct FlagRule {
  const char* name;
  unsigned commands;  // those that take it
  std::variant<Range, Choice, Color, Switch, Text> values;
};
const std::vector<FlagRule>& FlagRules();
// Null where there is none of that name.
const FlagRule* FindFlag(const std::string& name);
// How the command is written, without the flags that may be left out: "vesta train SCENE --out=DIR".
std::string UsageForm(const CommandInfo& command);

// Whether the flag was given on the command line.
bool IsSet(const char* name);

}  // namespace vesta::app
