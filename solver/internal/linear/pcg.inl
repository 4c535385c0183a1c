// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/linear/pcg.h.
#pragma once

#include <cmath>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/internal/linear/pcg.h"

namespace vesta {

template <Backend B>
void PcgWorkspace<B>::Resize(Index size) {
  for (typename B::Vector* vector : {&r, &p, &w}) {
    if (vector->size() != size) vector->Resize(size);
  }
}

template <Backend B>
PcgSummary SolvePcg(const PcgOptions& options, B& backend, LinearOperator<B>& a, typename B::ConstVectorView b,
                    LinearOperator<B>& m_inverse, PcgWorkspace<B>& workspace, typename B::VectorView x,
                    typename B::ConstVectorView norm_weights, const InnerProducts<B>& products) {
  const Index n = a.size();
  VESTA_CHECK(b.size() == n && x.size() == n && m_inverse.size() == n,
              "operator of {}, preconditioner of {}, vectors of {} and {}", n, m_inverse.size(), b.size(), x.size());
  workspace.Resize(n);
  auto &r = workspace.r, &p = workspace.p, &w = workspace.w;
  auto& scalars = workspace.scalars;
  const auto slot = [&](PcgScalar s) { return backend.SlotOf(scalars, s); };
  const auto squared_norm = [&](typename B::ConstVectorView v, PcgScalar result) {
    if (norm_weights.empty()) {
      products.Dot(v, v, slot(result));
    } else {
      products.WeightedDot(norm_weights, v, v, slot(result));
    }
  };
  PcgSummary summary;
  const auto product = [&](typename B::ConstVectorView v, typename B::VectorView out) {
    const ScopedPhase phase("product");
    a.Apply(v, out);
    ++summary.products;
  };
  const auto precondition = [&](typename B::ConstVectorView v, typename B::VectorView out) {
    const ScopedPhase phase("preconditioner");
    m_inverse.Apply(v, out);
  };
  const auto true_residual = [&] {
    product(x, w);
    backend.Copy(b, r);
    backend.Axpby(-1.0, w, 1.0, r);
  };

  if (options.start == PcgStart::kPreconditioned) precondition(b, x);
  double model = 0;
  if (options.start == PcgStart::kZero) {
    backend.Fill(0, x);
    backend.Copy(b, r);
  } else {
    true_residual();
    model = -0.5 * (products.Dot(x, b) + products.Dot(x, r));
  }
  std::vector<double> start(kNumPcgScalars, 0.0);
  start[kPcgRelativeTolerance] = options.relative_tolerance;
  start[kPcgAbsoluteTolerance] = options.absolute_tolerance;
  start[kPcgModelTolerance] = options.model_tolerance;
  start[kPcgMinIterations] = options.min_iterations;
  start[kPcgModel] = model;
  backend.Write({start.data(), kNumPcgScalars}, scalars);

  squared_norm(b, kPcgRhsNorm2);
  squared_norm(r, kPcgResidualNorm2);
  precondition(r, w);
  products.Dot(r, w, slot(kPcgNewRz));
  backend.UpdatePcg(PcgPhase::kBegin, scalars);
  backend.Copy(w, p);

  // The flag may be one iteration old; UpdatePcgScalars then does nothing.
  for (int k = 1; k <= options.max_iterations && backend.ReadLagged(slot(kPcgStop)) == 0; ++k) {
    if (k > 1) {
      precondition(r, w);
      products.Dot(r, w, slot(kPcgNewRz));
      backend.UpdatePcg(PcgPhase::kDirection, scalars);
      backend.CgDirection(w, slot(kPcgBeta), p);
    }
    product(p, w);
    products.Dot(p, w, slot(kPcgCurvature));
    backend.UpdatePcg(PcgPhase::kStep, scalars);
    backend.CgStep(slot(kPcgAlpha), p, w, x, r);
    if (options.residual_reset_period > 0 && k % options.residual_reset_period == 0) true_residual();
    squared_norm(r, kPcgResidualNorm2);
    backend.UpdatePcg(PcgPhase::kResidual, scalars);
  }

  const std::vector<double> end = backend.Read(scalars);
  constexpr PcgStatus kStatusOfStop[] = {PcgStatus::kConverged, PcgStatus::kModelConverged, PcgStatus::kIndefinite,
                                         PcgStatus::kNonFinite};
  const int stop = static_cast<int>(end[kPcgStop]);
  summary.status = stop == 0 ? PcgStatus::kMaxIterations : kStatusOfStop[stop - 1];
  summary.iterations = static_cast<int>(end[kPcgIteration]);
  summary.rhs_norm = std::sqrt(end[kPcgRhsNorm2]);
  summary.residual_norm = std::sqrt(end[kPcgResidualNorm2]);
  // x may have overflowed even after convergence.
  if (!products.AllFinite(x)) {
    summary.status = PcgStatus::kNonFinite;
    backend.Fill(0, x);
    backend.Copy(b, r);
    summary.residual_norm = summary.rhs_norm;
  }
  return summary;
}

}  // namespace vesta
