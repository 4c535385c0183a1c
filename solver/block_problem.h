// SPDX-License-Identifier: Apache-2.0
// Problems made of residual blocks of any kind over parameter blocks of any kind: what a Ceres user knows as
// ceres::Problem, with the Jacobian held block by block.
#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/cost_function.h"
#include "solver/internal/blocks/block_structure.h"
#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/normal_equations/step_cost.h"
#include "solver/loss.h"
#include "solver/manifold.h"
#include "solver/problem_interfaces.h"

namespace vesta {

class BlockNormalMatrix;
class SparseCholesky;

// x holds all parameter blocks one after another in the order of being added, constant ones included; they keep their
// values. The step covers the free ones, in an order of the problem's own. Costs and Jacobians of residual blocks are
// evaluated in parallel. Misuse throws Error.
class BlockProblem final : public Problem<CpuBackend<double>>,
                           public OnManifold<CpuBackend<double>>,
                           public InUnits<CpuBackend<double>>,
                           public WithBounds<CpuBackend<double>>,
                           public WithPreconditioner<CpuBackend<double>>,
                           public WithSparseCholesky<CpuBackend<double>>,
                           public WithStepCounts,
                           public WithNames,
                           public Describes<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  struct Options {
    // Whether a group of blocks, no two in one residual block, may be eliminated from linear solves (points in bundle
    // adjustment): found by itself, used where it is most of the parameters.
    bool eliminate = true;
    // Called with x before every evaluation of the cost, and of the Jacobian (jacobians = true), from one thread.
    std::function<void(ConstVectorView x, bool jacobians)> evaluation_callback = {};
    // Makes a preconditioner of the caller's own, for PreconditionerKind::kAuto and kProblem.
    std::function<std::unique_ptr<Preconditioner<B>>()> make_preconditioner = {};
    // Largest sparse Cholesky factor, in GiB; > 0.
    double max_factor_gib = 4;
  };

  BlockProblem() = default;
  explicit BlockProblem(Options options) : options_(std::move(options)) {}

  // Returns the block's number: 0, 1, ...
  int AddParameterBlock(int size, std::shared_ptr<const Manifold> manifold = nullptr);
  void SetManifold(int block, std::shared_ptr<const Manifold> manifold);
  void SetConstant(int block, bool constant = true);
  // Bounds of one entry of a block. On a block with a manifold they are kept by projection after the step.
  void SetBounds(int block, int entry, double lower, double upper);
  // No loss: rho(s) = s. The blocks are as many as the cost function has, of its sizes, all different.
  void AddResidualBlock(std::shared_ptr<const CostFunction> cost, std::shared_ptr<const Loss> loss,
                        std::span<const int> blocks);
  void AddResidualBlock(std::shared_ptr<const CostFunction> cost, std::shared_ptr<const Loss> loss,
                        std::initializer_list<int> blocks) {
    AddResidualBlock(std::move(cost), std::move(loss), std::span(blocks.begin(), blocks.size()));
  }

  // Room for `count` residual blocks in all, for who knows their number.
  void ReserveResidualBlocks(std::size_t count);

  void set_evaluation_callback(std::function<void(ConstVectorView x, bool jacobians)> callback) {
    options_.evaluation_callback = std::move(callback);
  }

  int num_parameter_blocks() const { return static_cast<int>(parameters_.size()); }
  int parameter_block_size(int block) const { return Parameter(block).ambient_size; }
  // Where the block's numbers begin in x.
  Index offset(int block) const { return Parameter(block).ambient_offset; }
  // Where its entries begin in a step, and how many; -1 and 0 for constant blocks.
  Index tangent_offset(int block);
  int tangent_size(int block);

  Index num_parameters() const override { return num_parameters_; }
  Index num_tangent() const override { return Structure().num_tangent(); }
  // A unit is a residual block.
  Index num_units() const override { return static_cast<Index>(residuals_.size()); }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // The caller's own, if there is one. Else the sparse Cholesky factor where it is within max_factor_gib and pays
  // beside iterations (solver/internal/normal_equations/step_cost.h). Else block Jacobi.
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override;
  // The sparse Cholesky factor, whatever it costs. Throws Error where it is over max_factor_gib.
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() override;
  // Null where a preconditioner is the caller's own.
  const StepCounts* CountSteps(bool eliminating) override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;
  bool has_bounds() const override { return !lower_.empty(); }
  bool IsFeasible(ConstVectorView x) override { return DescribeInfeasible(x).empty(); }
  void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) override;
  void ClipStep(ConstVectorView x, VectorView step) override;
  // In the terms of parameter blocks and residual blocks, numbered from 0 in the order of being added.
  std::string NameTangent(Index k) override;
  std::string NameResidual(int batch, Index row) override;
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override;
  std::string DescribeInfeasible(ConstVectorView x) override;
  std::string DescribeDegenerate(ConstVectorView x) override;

 private:
  friend class BlockLinearization;
  friend class BlockParts;
  struct Term {
    std::shared_ptr<const CostFunction> cost;
    std::shared_ptr<const Loss> loss;
  };
  // What a linearization hands on to the next: memory, not contents.
  struct LinearizationMemory {
    B::Vector jacobian, residuals, product;
  };
  const ParameterBlock& Parameter(int block) const;
  void Changed();
  const BlockStructure& Structure() const;
  BlockNormalMatrix& NormalMatrix() const;
  // What an exact factor takes at least, known without a plan of it.
  StepCounts::Factor LeastFactor() const;
  // Null where the factor would be over max_factor_gib or the multiplications.
  std::shared_ptr<SparseCholesky> PlanCholesky(double max_multiplications) const;
  // Room for one residual block's evaluation, used again from block to block.
  struct Scratch {
    std::vector<const double*> arguments;
    std::vector<double*> jacobians;  // of each argument, by its own numbers; null where it is constant
    std::vector<double> residuals;
    std::vector<double> ambient;        // the Jacobians, one after another
    std::vector<double> plus_jacobian;  // of one block
  };
  // The arguments, and residuals that hold Unwritten.
  void Prepare(ConstVectorView x, std::size_t term, double* residuals, Scratch& scratch) const;
  // Residuals and Jacobians of a residual block, on entries that hold Unwritten before. Returns what the cost function
  // returns.
  bool EvaluateTerm(ConstVectorView x, std::size_t term, double* residuals, Scratch& scratch) const;
  double TermCost(ConstVectorView x, std::size_t term, Scratch& scratch) const;
  // What is not finite of one residual block; empty: nothing.
  std::string DescribeTerm(ConstVectorView x, std::size_t term, bool jacobians, Scratch& scratch) const;
  template <class UnitOf>
  double SumCosts(ConstVectorView x, Index count, const UnitOf& unit_of) const;
  // visit(x entry, step entry) for each free entry of a bounded problem that moves by itself.
  template <class Visit>
  void VisitEuclidean(const Visit& visit) const;

  Options options_;
  Index num_parameters_ = 0;
  std::vector<ParameterBlock> parameters_;
  std::vector<std::shared_ptr<const Manifold>> manifolds_;
  std::vector<bool> constant_;
  ResidualBlockList residuals_;
  std::vector<Term> terms_;
  std::vector<double> lower_, upper_;  // an entry of x each, or empty: no bounds
  mutable std::optional<BlockStructure> structure_;
  mutable LinearizationMemory memory_;
  // Kept from one linearization to the next: the sums of H, the plan of its factor, and the memory of both.
  mutable std::shared_ptr<BlockNormalMatrix> normal_matrix_;
  std::shared_ptr<SparseCholesky> cholesky_;
  std::optional<StepCounts> counts_;
};

}  // namespace vesta
