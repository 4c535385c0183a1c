// SPDX-License-Identifier: Apache-2.0
// The pairs of a kept and an eliminated parameter block that share residual blocks. Computed once per structure.
#pragma once

#include <span>
#include <vector>

#include "solver/internal/blocks/block_structure.h"

namespace vesta {

// A kept parameter block (F) and an eliminated one (E) that share residual blocks.
struct Coupling {
  int kept = 0, eliminated = 0;  // index among the kept, and among the eliminated free blocks
  Index first_term = 0;          // position of its terms
  Index first_value = 0;         // position of a dense matrix of this coupling, size of E x size of F
};

// The same coupling in the list of its eliminated block.
struct CoupledKept {
  int kept = 0;
  Index first_value = 0;
};

// A residual block that depends on both blocks of a coupling.
struct CouplingTerm {
  Index row = 0;                 // index in BlockStructure::rows
  int kept = 0, eliminated = 0;  // first columns of both blocks within its dense Jacobian
};

class Couplings {
 public:
  explicit Couplings(const BlockStructure& structure);

  // All couplings: by kept block, and within one kept block by eliminated block.
  std::span<const Coupling> all() const { return {couplings_.data(), couplings_.size() - 1}; }
  std::span<const Coupling> of_kept(int block) const {
    const auto k = static_cast<std::size_t>(block);
    return std::span(couplings_).subspan(first_of_kept_[k], first_of_kept_[k + 1] - first_of_kept_[k]);
  }
  // The couplings of an eliminated block, by kept block. Their matrices are consecutive.
  std::span<const CoupledKept> of_eliminated(int block) const {
    const auto e = static_cast<std::size_t>(block);
    return std::span(by_eliminated_)
        .subspan(first_of_eliminated_[e], first_of_eliminated_[e + 1] - first_of_eliminated_[e]);
  }
  // In the order of the residual blocks. `coupling` must be an element of all().
  std::span<const CouplingTerm> terms(const Coupling& coupling) const {
    const auto first = static_cast<std::size_t>(coupling.first_term);
    return std::span(terms_).subspan(first, static_cast<std::size_t>((&coupling + 1)->first_term) - first);
  }
  // Number of values of one dense matrix per coupling.
  Index num_values() const { return num_values_; }

 private:
  std::vector<Coupling> couplings_;  // and a last element, whose first_term is the number of terms
  std::vector<CouplingTerm> terms_;
  std::vector<std::size_t> first_of_kept_, first_of_eliminated_;
  std::vector<CoupledKept> by_eliminated_;
  Index num_values_ = 0;
};

}  // namespace vesta
