// SPDX-License-Identifier: Apache-2.0
// Sparse Cholesky factors of symmetric positive definite block matrices, by the multifrontal method, and the factor of
// H + lambda D as a preconditioner: conjugate gradients then take an iteration or two.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"
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

// A linearization that can give H as a matrix.
class NormalMatrixSource {
 public:
  virtual ~NormalMatrixSource() = default;
  // H = J^T W J, on a pattern that all linearizations of a problem share. Made when first asked for; valid as long as
  // this object.
  virtual const BlockMatrix& NormalMatrix() = 0;
};

// What a problem keeps from one linearization, and from one solve, to the next: the plan, and the factor's memory.
class SparseCholesky {
 public:
  // Plans for a pattern. Null where the factor would take more than max_bytes, or factorising it more than
  // max_multiplications.
  static std::shared_ptr<SparseCholesky> Plan(const BlockPattern& pattern, double max_bytes,
                                              double max_multiplications = std::numeric_limits<double>::infinity());

  const EliminationPlan& plan() const { return *plan_; }
  double bytes() const { return BlockCholesky::Bytes(*plan_); }
  // The factor last given out where nobody holds it any more, since its memory is large; otherwise another one.
  std::shared_ptr<BlockCholesky> Factor() {
    return factor_.Get([&] { return std::make_shared<BlockCholesky>(plan_); });
  }

 private:
  explicit SparseCholesky(EliminationPlan plan) : plan_(std::make_shared<EliminationPlan>(std::move(plan))) {}

  std::shared_ptr<const EliminationPlan> plan_;
  Kept<BlockCholesky> factor_;
};

class SparseCholeskyPreconditioner final : public Preconditioner<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // For linearizations that are NormalMatrixSources on the pattern that was planned for. why: added to the description.
  explicit SparseCholeskyPreconditioner(std::shared_ptr<SparseCholesky> cholesky, std::string why = "");

  Index size() const override { return cholesky_->plan().num_scalars; }
  // After SetDamping.
  void Apply(B::ConstVectorView x, B::VectorView y) override { factor_->Solve(x, y); }
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, B::ConstVectorView diag_h) override;
  void SetDamping(double lambda, B::ConstVectorView metric) override;
  bool exact() const override { return true; }
  // Pivots of the last damping that had cancelled, and were raised (BlockCholesky::Factorize).
  Index num_raised() const { return num_raised_; }
  std::string description() const override;

 private:
  std::shared_ptr<SparseCholesky> cholesky_;
  std::string why_;
  NormalMatrixSource* source_ = nullptr;
  std::shared_ptr<BlockCholesky> factor_;  // from the first damping on
  Index num_raised_ = 0;
};

}  // namespace vesta
