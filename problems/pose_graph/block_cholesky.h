// Sparse Cholesky factors of symmetric positive definite block matrices, by the multifrontal method.
#pragma once

#include <memory>
#include <vector>

#include "problems/pose_graph/elimination.h"
#include "problems/pose_graph/front_kernels.h"

namespace vesta::pose_graph {

// The factor's values. Results do not depend on the number of threads.
class BlockCholesky {
 public:
  // block_size is 3 or 6.
  BlockCholesky(std::shared_ptr<const EliminationPlan> plan, int block_size);

  // Factorises matrix + scale * diag(added); added has the matrix's size. The matrix has the pattern that was planned
  // for. Pivots that cancel to below 1e-13 of their diagonal entry are raised to that, since a preconditioner must be
  // positive definite and need not be exact; returns their number.
  Index Factorize(const BlockMatrix& matrix, double scale, HostSpan<const double> added);
  // y = (L L^T)^-1 x. The same memory may be given for both.
  void Solve(HostSpan<const double> x, HostSpan<double> y);

 private:
  // Storage for updates, passed from front to front of one subtree.
  class Pool {
   public:
    // At least `size` values, of any content.
    std::vector<double> Take(std::size_t size);
    void Give(std::vector<double> values) { free_.push_back(std::move(values)); }

   private:
    std::vector<std::vector<double>> free_;
  };

  Panel PanelOf(Index front);
  // The front's matrix less what its children eliminated, then its factor and its update; returns the raised pivots.
  // parallel: shares the front's own work among the threads.
  Index FactorizeFront(Index front, const BlockMatrix& matrix, double scale, HostSpan<const double> added,
                       bool parallel);
  Index FactorizePanel(const Panel& panel, const double* least, bool parallel) const;
  template <int D>
  void AddChild(const EliminationFront& child, const double* update, const Panel& panel, double* parent_update) const;

  std::shared_ptr<const EliminationPlan> plan_;
  const Index block_size_;
  const FrontKernels& kernels_;
  std::vector<Index> first_value_;  // of each front's panel
  HostBuffer<double> values_;       // panels
  std::vector<Pool> pools_;         // one for each subtree, one for each front above them
  std::vector<std::size_t> pool_of_front_;
  std::vector<std::vector<double>> updates_;  // of the fronts that wait for their parents
  HostBuffer<double> permuted_, local_;       // of Solve
};

}  // namespace vesta::pose_graph
