// SPDX-License-Identifier: Apache-2.0
// Sparse Cholesky factors of symmetric positive definite block matrices, by the multifrontal method.
#pragma once

#include <memory>
#include <vector>

#include "solver/internal/sparse_cholesky/elimination.h"
#include "solver/internal/sparse_cholesky/front_kernels.h"

namespace vesta {

// The factor's values. Results do not depend on the number of threads.
class BlockCholesky {
 public:
  explicit BlockCholesky(std::shared_ptr<const EliminationPlan> plan);
  // Memory that a factor of this plan holds, that of its updates while it is being made apart.
  static double Bytes(const EliminationPlan& plan);

  // Factorises matrix + scale * diag(added); added has the matrix's size. The matrix has the pattern that was planned
  // for. Pivots that cancel to below 1e-13 of their diagonal entry are raised to that, since a preconditioner must be
  // positive definite and need not be exact; returns their number.
  Index Factorize(const BlockMatrix& matrix, double scale, HostSpan<const double> added);
  // y = (L L^T)^-1 x. The same memory may be given for both.
  void Solve(HostSpan<const double> x, HostSpan<double> y);

 private:
  // Storage for updates, passed from front to front.
  class Pool {
   public:
    // At least `size` values, of any content.
    std::vector<double> Take(std::size_t size);
    void Give(std::vector<double> values) { free_.push_back(std::move(values)); }

   private:
    std::vector<std::vector<double>> free_;
  };

  // What is factorised: matrix + scale * diag(added).
  struct Input {
    const BlockMatrix& matrix;
    double scale;
    HostSpan<const double> added;
  };

  FrontPanel PanelOf(Index front);
  // These return the raised pivots.
  Index FactorizeSubtree(const EliminationSubtree& subtree, const Input& input);
  // A front that holds its own part of the matrix and its children's updates: its factor and its update. parallel:
  // shares the work among the threads.
  Index FactorizeFront(Index front, const Input& input, bool parallel);
  Index FactorizePanel(const FrontPanel& panel, const double* least, bool parallel) const;
  // Puts the front's own part of the matrix into its panel, and takes memory for its update; once.
  void Assemble(Index front, const Input& input);
  // Adds a front's update to its parent's panel and update, and gives its memory back.
  void AddToParent(Index front, const Input& input);

  std::shared_ptr<const EliminationPlan> plan_;
  const FrontKernels& kernels_;
  std::vector<Index> first_value_;  // of each front's panel
  HostBuffer<double> values_;       // panels
  std::vector<Pool> pools_;         // one for each subtree of a wave, one for each front above them
  std::vector<std::size_t> pool_of_front_;
  std::vector<std::vector<double>> updates_;  // of the fronts being assembled, or waiting for their parents
  std::vector<char> assembled_;
  HostBuffer<double> least_;             // of each pivot, in the order of elimination
  HostBuffer<double> permuted_, local_;  // of Solve
};

}  // namespace vesta
