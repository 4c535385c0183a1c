// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/preconditioner.h"

namespace vesta {

const char* ToString(PreconditionerKind kind) {
  switch (kind) {
    case PreconditionerKind::kAuto:
      return "automatic";
    case PreconditionerKind::kIdentity:
      return "no preconditioner";
    case PreconditionerKind::kJacobi:
      return "Jacobi";
    case PreconditionerKind::kBlockJacobi:
      return "block Jacobi";
    case PreconditionerKind::kProblem:
      return "the problem's preconditioner";
    case PreconditionerKind::kSparseCholesky:
      return "sparse Cholesky";
  }
  return "unknown";
}

}  // namespace vesta
