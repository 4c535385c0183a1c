#include "bench/training_race/variants.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "bench/training_race/adam_schedules.h"

namespace vesta::bench {
namespace {

using Options = gs::TrainOptions;

struct Change {
  const char *knob, *name;
  std::function<void(Options&)> apply;
};

// LM from the reference's state. A new option of LM is a line here for each of its values.
const std::vector<Change>& LmChanges() {
  static const std::vector<Change> changes = {
      {"noise", "initial lambda x 0.95", [](Options& o) { o.lm.initial_lambda *= 0.95; }},
      {"noise", "initial lambda x 1.05", [](Options& o) { o.lm.initial_lambda *= 1.05; }},

      {"PCG iterations", "2", [](Options& o) { o.lm.pcg_iterations = 2; }},
      {"PCG iterations", "4", [](Options& o) { o.lm.pcg_iterations = 4; }},
      {"PCG iterations", "6", [](Options& o) { o.lm.pcg_iterations = 6; }},
      {"PCG iterations", "8", [](Options& o) { o.lm.pcg_iterations = 8; }},
      {"PCG iterations", "16", [](Options& o) { o.lm.pcg_iterations = 16; }},

      {"step control", "ceres", [](Options& o) { o.lm.step_control = "ceres"; }},
      {"step control", "v1", [](Options& o) { o.lm.step_control = "v1"; }},
      {"step control", "v2", [](Options& o) { o.lm.step_control = "v2"; }},
      {"step control", "code", [](Options& o) { o.lm.step_control = "code"; }},

      // diag(JtJ) is another scale: several starts.
      {"damping", "diag", [](Options& o) { o.lm.damping = "diag"; }},
      {"damping", "diag, from 0.1", [](Options& o) { o.lm.damping = "diag", o.lm.initial_lambda = 0.1; }},
      {"damping", "diag, from 1", [](Options& o) { o.lm.damping = "diag", o.lm.initial_lambda = 1; }},
      {"weight of the rates", "x 0.1", [](Options& o) { o.lm.rates_damping *= 0.1; }},
      {"weight of the rates", "x 0.3", [](Options& o) { o.lm.rates_damping *= 0.3; }},
      {"weight of the rates", "x 3", [](Options& o) { o.lm.rates_damping *= 3; }},
      {"weight of the rates", "x 10", [](Options& o) { o.lm.rates_damping *= 10; }},
      {"initial lambda", "x 0.1", [](Options& o) { o.lm.initial_lambda *= 0.1; }},
      {"initial lambda", "x 10", [](Options& o) { o.lm.initial_lambda *= 10; }},

      {"preconditioner", "jacobi", [](Options& o) { o.lm.preconditioner = "jacobi"; }},
      {"preconditioner", "block_sh", [](Options& o) { o.lm.preconditioner = "block_sh"; }},
      {"weight of turning", "0", [](Options& o) { o.lm.rotation_damping = 0; }},
      {"weight of the harmonics", "1", [](Options& o) { o.lm.sh_damping = 1; }},
      {"weight of the harmonics", "0.0025", [](Options& o) { o.lm.sh_damping = 0.0025; }},
      {"agreement of views", "0", [](Options& o) { o.lm.view_agreement = 0; }},
      {"agreement of views", "0.1", [](Options& o) { o.lm.view_agreement = 0.1; }},
      {"agreement of views", "1", [](Options& o) { o.lm.view_agreement = 1; }},
      {"weight of moving", "1", [](Options& o) { o.lm.position_damping = 1; }},
      {"weight of moving", "20", [](Options& o) { o.lm.position_damping = 20; }},

      {"|error|", "as the square of its root", [](Options& o) { o.lm.loss_linearization = "sqrt"; }},
      {"|error|", "huber", [](Options& o) { o.lm.loss_linearization = "huber"; }},
      {"|error|", "l2", [](Options& o) { o.lm.loss_linearization = "l2"; }},
      {"SSIM", "root, exact", [](Options& o) { o.lm.ssim_linearization = "root"; }},
      {"SSIM", "root, centre", [](Options& o) { o.lm.ssim_linearization = "root", o.lm.ssim_jacobian = "center"; }},

      {"sampling", "rows, 1/2", [](Options& o) { o.lm.residual_sampling = 0.5; }},
      {"sampling", "rows, 1/4", [](Options& o) { o.lm.residual_sampling = 0.25; }},
      {"sampling", "tiles, 1/2", [](Options& o) { o.lm.residual_sampling = 0.5, o.lm.sampling_unit = "tiles"; }},
      {"sampling", "rows, 1/2, gradient too",
       [](Options& o) { o.lm.residual_sampling = 0.5, o.lm.sample_gradient = true; }},
      {"limit on steps", "caps", [](Options& o) { o.lm.step_limit = "caps"; }},
      {"limit on steps", "hellinger", [](Options& o) { o.lm.step_limit = "hellinger", o.lm.step_limit_size = 0.1; }},
      {"Jacobian", "recompute", [](Options& o) { o.lm.jacobian = "recompute"; }},
      {"Jacobian", "cache32", [](Options& o) { o.lm.jacobian = "cache32"; }},
      {"Jacobian", "cache16", [](Options& o) { o.lm.jacobian = "cache16"; }},

      {"views a step", "8", [](Options& o) { o.lm.batch_size = 8; }},
      {"views a step", "8, random", [](Options& o) { o.lm.batch_size = 8, o.lm.batch_choice = "random"; }},
      {"batches", "2, exact sum", [](Options& o) { o.lm.batches = 2; }},
      {"batches", "4, exact sum", [](Options& o) { o.lm.batches = 4; }},
      {"batches", "2, merged", [](Options& o) { o.lm.batches = 2, o.lm.merge_batches = true; }},
      {"batches", "4, merged", [](Options& o) { o.lm.batches = 4, o.lm.merge_batches = true; }},

      {"line search", "30 % of the views", [](Options& o) { o.lm.line_search = true, o.lm.line_search_views = 0.3; }},
      {"line search", "all views", [](Options& o) { o.lm.line_search = true, o.lm.line_search_views = 1; }},

      {"floor of L1", "0.001", [](Options& o) { o.lm.l1_floor = 0.001; }},
      {"floor of L1", "0.003", [](Options& o) { o.lm.l1_floor = 0.003; }},
      {"floor of L1", "0.03", [](Options& o) { o.lm.l1_floor = 0.03; }},

      {"preset", "fast", [](Options& o) { o.lm = gs::PresetOptions("fast").lm; }},
      {"preset", "paper", [](Options& o) { o.lm = gs::PresetOptions("paper").lm; }},
      {"preset", "paper_code", [](Options& o) { o.lm = gs::PresetOptions("paper_code").lm; }},
  };
  return changes;
}

// Whole trainings, as long as the reference's. whole: that time in times of its Adam stage.
std::vector<Change> WholeChanges(double whole) {
  const auto times = [](const Options& o, double factor) {
    return std::max(1, static_cast<int>(factor * o.adam.iterations));
  };
  return {
      {"when to switch", "Adam x 0.25", [=](Options& o) { o.adam.iterations = times(o, 0.25); }},
      {"when to switch", "Adam x 0.5", [=](Options& o) { o.adam.iterations = times(o, 0.5); }},
      {"when to switch", "Adam x 0.75", [=](Options& o) { o.adam.iterations = times(o, 0.75); }},
      {"when to switch", "after a cooldown, without a mean",
       [](Options& o) { o.adam.cooldown = 0.1, o.adam.average_part = 0; }},
      {"when to switch", "after a cooldown, and the mean", [](Options& o) { o.adam.cooldown = 0.1; }},
      {"when to switch", "Adam x 1.5", [=](Options& o) { o.adam.iterations = times(o, 1.5); }},
      {"no LM", "Adam alone", [=](Options& o) { o = AdamAlone(o, times(o, whole), o.adam.rate_factor); }},
      {"no LM", "Adam alone, 4 views an iteration",
       [=](Options& o) { o = LargeBatchAdam(o, times(o, whole), o.adam.rate_factor, 4); }},
      {"no LM", "Adam alone, 16 views an iteration",
       [=](Options& o) { o = LargeBatchAdam(o, times(o, whole), o.adam.rate_factor, 16); }},
  };
}

}  // namespace

std::vector<Variant> Variants(const gs::TrainOptions& reference, double budget) {
  std::vector<Variant> variants = {{"reference", "as given", reference, false}};
  const auto add = [&](const Change& change, bool from_points) {
    variants.push_back({change.knob, change.name, reference, from_points});
    change.apply(variants.back().options);
  };
  for (const Change& change : LmChanges()) add(change, false);
  for (const Change& change : WholeChanges(1 + budget)) add(change, true);
  return variants;
}

}  // namespace vesta::bench
