// Options of the LM stage.
#pragma once

#include <string>

namespace vesta::gs {

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
  std::string step_control = "soft";  // soft | ceres | v1 | v2 | code
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

}  // namespace vesta::gs
