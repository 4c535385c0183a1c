// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/linear/lsmr.h.
#pragma once

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/internal/linear/lsmr.h"

namespace vesta {

namespace lsmr_internal {

// The rotation [c s; -s c] with [c s; -s c] (a, b)^T = (r, 0)^T.
struct Rotation {
  double c = 1, s = 0, r = 0;
  Rotation(double a, double b) : r(std::hypot(a, b)) {
    if (r > 0) {
      c = a / r;
      s = b / r;
    }
  }
};

}  // namespace lsmr_internal

template <Backend B>
LsmrSummary SolveLsmr(const LsmrOptions& options, B& backend, LinearMap<B>& a, typename B::ConstVectorView b,
                      typename B::VectorView x) {
  using lsmr_internal::Rotation;
  VESTA_CHECK(b.size() == a.rows() && x.size() == a.cols(), "map of {} x {}, vectors of {} and {}", a.rows(), a.cols(),
              b.size(), x.size());
  typename B::Vector u(a.rows()), Av(a.rows()), v(a.cols()), Atu(a.cols()), h(a.cols()), h_bar(a.cols()),
      next(a.cols());
  const auto normalise = [&](typename B::Vector& vector) {
    const double norm = std::sqrt(backend.Dot(vector.view(), vector.view()));
    if (norm > 0) backend.Axpby(0.0, vector, 1.0 / norm, vector);
    return norm;
  };
  const auto apply = [&] {
    const ScopedPhase phase("product");
    a.Apply(v, Av);
  };
  const auto apply_adjoint = [&](typename B::Vector& result) {
    const ScopedPhase phase("product");
    a.ApplyAdjoint(u, result);
  };
  backend.Fill(0, x);
  backend.Copy(b, u);
  const double beta1 = normalise(u);
  LsmrSummary summary;
  summary.residual_norm = beta1;
  double alpha = 0;
  if (beta1 > 0) {
    apply_adjoint(v);
    alpha = normalise(v);
  }
  summary.normal_residual_norm = alpha * beta1;
  summary.finite = std::isfinite(summary.normal_residual_norm);
  // alpha = 0 at the start: x = 0 is a solution, because b is orthogonal to the range of A.
  summary.converged = summary.finite && summary.normal_residual_norm == 0;
  if (!summary.finite || summary.converged) return summary;

  // Names follow section 2.8 of the paper: the rotations of the QR factorisations of B_k and of R_k^T, then the
  // recursions of the iterate and of the norms (section 5).
  double alpha_bar = alpha, zeta_bar = alpha * beta1, rho = 1, rho_bar = 1, c_bar = 1, s_bar = 0;
  double beta_dd = beta1, beta_d = 0, rho_d_old = 1, tau_tilde_old = 0, theta_tilde = 0, zeta_old = 0;
  double norm_a2 = alpha * alpha;
  backend.Copy(v, h);
  for (int k = 1; k <= options.max_iterations; ++k) {
    apply();
    backend.Axpby(1.0, Av, -alpha, u);
    const double beta = normalise(u);
    apply_adjoint(Atu);
    backend.Axpby(1.0, Atu, -beta, v);
    alpha = normalise(v);

    const double rho_old = rho, rho_bar_old = rho_bar;
    const Rotation p(alpha_bar, beta);
    rho = p.r;
    const double theta = p.s * alpha;
    alpha_bar = p.c * alpha;
    const double theta_bar = s_bar * rho;
    const Rotation q(c_bar * rho, theta);
    c_bar = q.c;
    s_bar = q.s;
    rho_bar = q.r;
    const double zeta = c_bar * zeta_bar;
    zeta_bar = -s_bar * zeta_bar;

    // h_bar = h - (theta_bar rho / (rho_old rho_bar_old)) h_bar;  x += zeta / (rho rho_bar) h_bar;  h = v - theta/rho h
    backend.Axpby(1.0, h, k == 1 ? 0.0 : -theta_bar * rho / (rho_old * rho_bar_old), h_bar);
    backend.Copy(x, next);
    backend.Axpby(zeta / (rho * rho_bar), h_bar, 1.0, next);
    if (!std::isfinite(zeta) || !backend.AllFinite(next)) {
      summary.finite = false;
      return summary;
    }
    backend.Copy(next, x);
    backend.Axpby(1.0, v, -theta / rho, h);

    // |r| by one more rotation (section 5.1 of the paper, without the regularisation).
    const double beta_hat = p.c * beta_dd;
    beta_dd = -p.s * beta_dd;
    const double theta_tilde_old = theta_tilde;
    const Rotation t(rho_d_old, theta_bar);
    theta_tilde = t.s * rho_bar;
    rho_d_old = t.c * rho_bar;
    beta_d = -t.s * beta_d + t.c * beta_hat;
    tau_tilde_old = (zeta_old - theta_tilde_old * tau_tilde_old) / t.r;
    const double tau_d = (zeta - theta_tilde * tau_tilde_old) / rho_d_old;
    zeta_old = zeta;
    summary.residual_norm = std::hypot(beta_d - tau_d, beta_dd);
    summary.normal_residual_norm = std::abs(zeta_bar);
    summary.iterations = k;
    norm_a2 += beta * beta + alpha * alpha;
    if (summary.normal_residual_norm <= options.relative_tolerance * std::sqrt(norm_a2) * summary.residual_norm ||
        summary.normal_residual_norm == 0) {
      summary.converged = true;
      return summary;
    }
  }
  return summary;
}

}  // namespace vesta
