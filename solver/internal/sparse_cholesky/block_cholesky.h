// SPDX-License-Identifier: Apache-2.0
// Sparse Cholesky factorisation of symmetric positive definite block matrices by the multifrontal method
// (elimination.h). PCG needs one or two iterations with the factor of H + lambda D as its preconditioner.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"
#include "solver/internal/sparse_cholesky/elimination.h"
#include "solver/internal/sparse_cholesky/front_kernels.h"

namespace vesta {

// A Cholesky factor L with L L^T = the matrix, up to a permutation. It does not depend on the number of threads.
class BlockCholesky {
 public:
  explicit BlockCholesky(std::shared_ptr<const EliminationPlan> plan);
  // Bytes of a factor of this plan, without the update matrices during factorisation.
  static double Bytes(const EliminationPlan& plan);

  // Factorises matrix + scale * diag(added). The matrix must have the planned pattern; `added` has one entry per scalar
  // row. A pivot below 1e-13 times its diagonal entry is raised to this value, so that the factor is always positive
  // definite. Returns the number of raised pivots.
  Index Factorize(const BlockMatrix& matrix, double scale, HostSpan<const double> added);
  // y = (L L^T)^-1 x. x and y may be the same memory.
  void Solve(HostSpan<const double> x, HostSpan<double> y);

 private:
  // Buffers for update matrices, reused by later fronts. Threads may share a pool.
  class Pool {
   public:
    // Returns `size` values with arbitrary contents.
    HostBuffer<double> Acquire(Index size);
    void Release(HostBuffer<double> values);

   private:
    std::mutex mutex_;
    std::vector<HostBuffer<double>> free_;
  };

  // The matrix to factorise: matrix + scale * diag(added).
  struct Input {
    const BlockMatrix& matrix;
    double scale;
    HostSpan<const double> added;
  };

  FrontPanel PanelOf(Index front);
  // These functions return the number of raised pivots.
  Index FactorizeSubtree(const EliminationSubtree& subtree, const Input& input);
  // Factorises a front after the updates of all its children were added, and computes its own update matrix. parallel:
  // on several threads.
  Index FactorizeFront(Index front, const Input& input, bool parallel);
  // least: smallest allowed value of each pivot.
  Index FactorizePanel(const FrontPanel& panel, const double* least, bool parallel) const;
  // Copies the front's entries of the matrix to its panel, and allocates its update matrix. Only the first call in a
  // factorisation has an effect.
  void Assemble(Index front, const Input& input);
  // Adds a front's update matrix to its parent's panel and update matrix, then releases it.
  void AddToParent(Index front, const Input& input);

  std::shared_ptr<const EliminationPlan> plan_;
  const FrontKernels& kernels_;
  std::vector<Index> first_value_;  // per front: position of its panel in values_
  HostBuffer<double> values_;       // the panels of all fronts: their columns of L
  Pool pool_;
  std::vector<HostBuffer<double>> updates_;  // per front, until it is added to the parent
  std::vector<char> assembled_;              // per front: 1 after Assemble
  HostBuffer<double> least_;                 // smallest allowed value per pivot, in elimination order
  HostBuffer<double> permuted_, local_;      // work memory of Solve
};

// A linearization that can return H as a matrix.
class NormalMatrixSource {
 public:
  virtual ~NormalMatrixSource() = default;
  // H = J^T W J, computed at the first call and valid as long as this object. All linearizations of a problem must use
  // the same pattern, unless the preconditioner plans a factor for each linearization.
  virtual const BlockMatrix& NormalMatrix() = 0;
};

// A plan and the memory of its factor, for all linearizations and solves of a problem.
class SparseCholesky {
 public:
  // Returns null if the factor would need more than max_bytes or max_multiplications. In this case, sets `exceeded`, if
  // not null, to that limit.
  static std::shared_ptr<SparseCholesky> Plan(const BlockPattern& pattern, double max_bytes,
                                              double max_multiplications = std::numeric_limits<double>::infinity(),
                                              ExceededLimit* exceeded = nullptr);

  // The same plan for another pattern, whose blocks have another size; takes less time than Plan. planned: the pattern
  // of this plan. Null if the patterns do not have the same blocks, or not one size each.
  std::shared_ptr<SparseCholesky> ForPattern(const BlockPattern& planned, const BlockPattern& other) const;

  const EliminationPlan& plan() const { return *plan_; }
  double bytes() const { return BlockCholesky::Bytes(*plan_); }
  // Text for reports, such as "sparse Cholesky of 1.5 MiB".
  std::string description() const;
  // An object for a factor. Reuses the previous object, whose memory is large, if it is no longer in use.
  std::shared_ptr<BlockCholesky> Factor() {
    return factor_.Get([&] { return std::make_shared<BlockCholesky>(plan_); });
  }

 private:
  explicit SparseCholesky(EliminationPlan plan) : plan_(std::make_shared<EliminationPlan>(std::move(plan))) {}

  std::shared_ptr<const EliminationPlan> plan_;
  Reusable<BlockCholesky> factor_;
};

class SparseCholeskyPreconditioner final : public Preconditioner<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // For linearizations that derive from NormalMatrixSource and have the planned pattern. why: reason for this
  // preconditioner, for the description.
  explicit SparseCholeskyPreconditioner(std::shared_ptr<SparseCholesky> cholesky, std::string why = "");
  // Plans the factor again in each SetLinearization; plan must not return null.
  using Plan = std::function<std::shared_ptr<SparseCholesky>(const BlockPattern& pattern)>;
  explicit SparseCholeskyPreconditioner(Plan plan) : plan_(std::move(plan)) {}

  // 0 before the first plan.
  Index size() const override { return cholesky_ ? cholesky_->plan().num_scalars : 0; }
  // Call it after SetDamping.
  void Apply(B::ConstVectorView x, B::VectorView y) override { factor_->Solve(x, y); }
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, B::ConstVectorView diag_h) override;
  void SetDamping(double lambda, B::ConstVectorView metric) override;
  bool exact() const override { return true; }
  // Pivots that the last SetDamping raised (BlockCholesky::Factorize).
  Index num_raised() const { return num_raised_; }
  std::string description() const override;

 private:
  Plan plan_;  // empty if the plan is always the same
  std::shared_ptr<SparseCholesky> cholesky_;
  std::string why_;
  NormalMatrixSource* source_ = nullptr;
  std::shared_ptr<BlockCholesky> factor_;  // null before the first SetDamping
  Index num_raised_ = 0;
};

}  // namespace vesta
