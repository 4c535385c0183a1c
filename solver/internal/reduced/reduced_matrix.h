// SPDX-License-Identifier: Apache-2.0
// Plan of the matrix S of a reduced system (solver/reduced_system.h), and of its sparse Cholesky factor.
#pragma once

#include <memory>
#include <string>

#include "kernels/core/vector_backend.h"
#include "solver/internal/reduced/couplings.h"
#include "solver/internal/sparse_cholesky/factored_matrix.h"

namespace vesta {

class ReducedMatrixPlan {
 public:
  // The matrix with its factor, and one dense matrix per coupling (Coupling::first_value).
  struct Memory {
    FactoredMatrix matrix;
    CpuBackend<double>::Vector couplings;
  };

  // Returns null if the factor, S with the dense matrices of the couplings, or the list of the blocks of S would need
  // more than max_bytes, or the factor more than max_multiplications. In this case, sets `exceeded`, if not null, to
  // that limit.
  static std::shared_ptr<ReducedMatrixPlan> Make(const BlockStructure& structure, const Couplings& couplings,
                                                 double max_bytes, double max_multiplications,
                                                 ExceededLimit* exceeded = nullptr);
  // Number of multiplications that compute S once, without the factor.
  static double Multiplications(const BlockStructure& structure, const Couplings& couplings);

  const SparseCholesky& cholesky() const { return *cholesky_; }
  // Memory for one linearization. Reuses the previous memory if it is no longer in use.
  std::shared_ptr<Memory> GetMemory();
  std::string description() const { return cholesky_->description(); }

 private:
  ReducedMatrixPlan() = default;

  std::shared_ptr<const BlockPattern> pattern_;  // one row per kept block
  std::shared_ptr<SparseCholesky> cholesky_;
  Index num_coupling_values_ = 0;
  Reusable<Memory> memory_;
};

}  // namespace vesta
