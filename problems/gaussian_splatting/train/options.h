// Everything a training run can be told, as plain data with defaults. apps/ fills it from flags; nothing else does.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "kernels/core/span.h"

namespace vesta::gs {

// Adam's learning rates by class of parameter, for the mean photometric loss of one view (Kerbl et al. 2023, the
// authors' code). Of positions in units of length (length_units.h); of opacity as in later versions of that code. They
// also are the metric in which LM damps.
struct LearningRates {
  double position = 1.6e-4;
  double log_scale = 5e-3;
  double quaternion = 1e-3;
  double opacity = 0.025;
  double sh_dc = 2.5e-3;
  double sh_rest = 1.25e-4;
};

struct AdamOptions {
  int iterations = 4000;
  // The gradient of an iteration is the mean over the next so many training views, in the order of the epochs.
  int views_per_iteration = 1;
  // When LM takes over: after these iterations, or sooner where it gains more for its work (stage_switch.h).
  std::string switch_to_lm = "fixed";  // fixed | auto
  // What scales the gradient of a Gaussian's geometry: of each parameter its own second moment, or of all eleven
  // together their eigenbasis (block_adam_formula.h).
  std::string metric = "block";  // block | diagonal
  // The authors' rates are made for 30,000 iterations; short runs want several times as much.
  // All rates times this at the start, and the factor by which they have fallen, geometrically, at the end.
  double rate_factor = 4.0;
  double rate_decay = 0.5;
  // In the last part of the stage, so long, they fall besides by another factor: high rates come far and end in noise,
  // which a short cooldown takes out. So does the mean below, and finds a better place (docs/results).
  double cooldown = 0;
  double cooldown_to = 0.03;
  // In the last part of the stage, so long, what it shows and leaves is the weighted mean of its parameters since the
  // last densification (parameter_mean.h); 0: the last ones. Counted from the end that was asked for: where LM takes
  // over before this part there is no mean.
  double average_part = 0.5;
  // The first part of the stage, so long, sees the views at half their size (coarse_views.h).
  double coarse_part = 0.5;
  // One more band of spherical harmonics after each of these parts of the run.
  double sh_band_every = 0.08;
  // Rows of the history, evenly spaced (more where the iterations do not divide).
  int evaluations = 20;
};

// Clone, split and prune (Kerbl et al. 2023, section 5.2). Times are parts of the Adam stage.
struct DensityOptions {
  bool enabled = true;
  double begin = 0.1;
  double end = 0.6;
  // As a part of the stage too: a longer training has more time for the same Gaussians, not more Gaussians.
  double every = 0.05;
  double gradient_threshold = 7e-4;  // mean norm of d loss / d mean in normalised device coordinates
  double split_above = 0.01;         // standard deviation, in scene extents: split above, clone below
  double prune_opacity = 0.005;
  double prune_size = 0;             // standard deviation, in scene extents; 0: no limit
  double opacity_reset_every = 0.0;  // 0: never
  Index max_gaussians = 500000;      // hard cap
};

// Levenberg-Marquardt on all training views (solver/), started from where Adam stopped.
struct LmOptions {
  int iterations = 8;
  // The stage ends before where an iteration lowers the cost by a smaller part than this: on some scenes Adam leaves
  // next to nothing to gain (docs/results).
  double min_gain = 0.006;
  int pcg_iterations = 4;
  int batches = 1;
  int batch_size = 0;                    // views in each; 0: all are divided among the batches
  std::string batch_choice = "strided";  // strided | random | clustered
  // Several batches: solved together in one PCG, or one by one and merged (3DGS-LM, eq. 7).
  bool merge_batches = false;
  std::string damping = "rates";         // rates | diag
  std::string preconditioner = "block";  // block | block_sh | jacobi
  // What damps the preconditioner: the damping of the system, none, or D itself (3DGS-LM's paper, and its code).
  std::string preconditioner_damping = "lambda";  // lambda | none | one
  std::string pcg_start = "zero";                 // zero | preconditioned: M^-1 b, at one more product
  // Stop PCG where |residual| <= pcg_tolerance |b|; 0: where the quadratic model hardly falls any more.
  double pcg_tolerance = 0;
  std::string step_control = "soft";  // soft | ceres | nielsen | v1 | v2 | code
  // recompute | cache32 | cache16 | rebuild: views that are held make iterations a quarter shorter and take several
  // times the memory of all else (docs/results).
  std::string jacobian = "rebuild";
  double residual_sampling = 1;        // part of the pixels of each view that H is measured on
  std::string sampling_unit = "rows";  // rows | tiles: how they are drawn
  bool sample_gradient = false;        // the gradient too
  std::string step_limit = "none";     // none | caps | hellinger
  double step_limit_size = 1;          // factor on the caps, or the bound on the squared Hellinger distance
  bool line_search = false;
  double line_search_views = 0.3;
  double initial_lambda = 0.02;
  double min_lambda = 1e-5;
  double max_lambda = 1e4;
  double rates_damping = 1.2;   // tau of the damping metric
  double position_damping = 5;  // factor on it for the means
  double rotation_damping = 1;  // weight in it of how far a splat's ends move when it turns
  double sh_damping = 0.02;     // factor on it for the bands of the harmonics above the constant
  double view_agreement = 0.3;  // how strongly gradients are shrunk where views disagree; 0: not
  double l1_floor = 0.01;       // epsilon of the reweighted L1
  // The cost and its quadratic: kernels/image/loss_options.h.
  std::string loss_linearization = "irls";       // irls | sqrt | huber | l2
  double huber_threshold = 0.1;                  // of huber
  std::string ssim_linearization = "quadratic";  // quadratic | root
  std::string ssim_jacobian = "exact";           // exact | center: with root
  double l1_weight = 0.8, ssim_weight = 0.2;
  // Range of diag(JtJ) in the damping metric "diag"; 0: at least 1e-6 of the median of the same parameter, no upper
  // end.
  double min_diagonal = 0, max_diagonal = 0;
};

// Whether entries of J are kept.
inline bool CachesJacobian(const LmOptions& lm) { return lm.jacobian == "cache32" || lm.jacobian == "cache16"; }

struct MemoryOptions {
  double budget_gib = 0;  // of the process; 0: none
  double before_mib = 0;  // what the process holds without the model: program, images
};

struct TrainOptions {
  MemoryOptions memory;
  AdamOptions adam;
  DensityOptions density;
  LmOptions lm;
  LearningRates rates;
  std::optional<int> sh_degree;  // of training; none: what the training views bear (DefaultShDegree)
  std::array<double, 3> background{0, 0, 0};
  std::uint64_t seed = 0;
  double time_limit = 0;  // seconds from the start of the process; 0: none
};

// Presets by name: fast, balanced, best, paper, paper_code. Throws Error for another name.
TrainOptions PresetOptions(const std::string& name);
// The same for refining what others trained, which LM alone has to improve: it gets at least 12 iterations, and goes on
// while there is anything to gain.
TrainOptions RefinePresetOptions(const std::string& name);

// Throws Error naming the option that is out of range.
void ValidateOptions(const TrainOptions& options);

}  // namespace vesta::gs
