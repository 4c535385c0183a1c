// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/step_solver.h"

namespace vesta {

const char* ToString(LinearSolverKind kind) {
  switch (kind) {
    case LinearSolverKind::kAuto:
      return "automatic";
    case LinearSolverKind::kPcg:
      return "PCG";
    case LinearSolverKind::kReducedPcg:
      return "PCG on the Schur complement";
    case LinearSolverKind::kLsmr:
      return "LSMR";
    case LinearSolverKind::kDenseQr:
      return "dense QR";
  }
  return "unknown";
}

}  // namespace vesta
