// SPDX-License-Identifier: Apache-2.0
// Problems that consist of residual blocks, as in ceres::Problem. Each residual block depends on a few parameter
// blocks. The Jacobian is stored block by block.
#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "solver/cost_function.h"
#include "solver/internal/blocks/block_structure.h"
#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/normal_equations/step_cost.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/manifold.h"
#include "solver/problem_interfaces.h"

namespace vesta {

class BlockNormalMatrix;
class Couplings;
class ReducedMatrixPlan;
class SparseCholesky;
enum class ExceededLimit;

// x holds all parameter blocks one after another, in the order in which they were added. x includes constant blocks and
// blocks that no residual block uses. A solve does not change these blocks. A step has entries only for the other
// blocks, the free blocks, in an order that the problem chooses (tangent_offset). Residual blocks without a free block
// have a fixed cost. A solve evaluates it once, at the start. The residual blocks are evaluated in parallel. Wrong
// arguments throw Error.
//
// Blocks may be added and removed between solves. All other blocks keep their indices, and parameter blocks keep their
// positions in x. A removed parameter block leaves unused entries in x. A new parameter block of the same size reuses
// these entries and the index. A new residual block reuses the index of a removed one with the same number of parameter
// blocks.
//
// x is an argument of each function that needs it. For callers who do not store x, the problem also keeps a value of
// each parameter block (Get, Set). SolveLm(problem) starts from these values and updates them.
class BlockProblem final : public Problem<CpuBackend<double>>,
                           public OnManifold<CpuBackend<double>>,
                           public WithFixedCost<CpuBackend<double>>,
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
    // Eliminate some parameter blocks from each linear solve (Schur complement), such as the points of bundle
    // adjustment. The problem searches for parameter blocks that share no residual block with each other. It eliminates
    // them only if they contain most of the parameters.
    bool eliminate = true;
    // Called with x before every evaluation of the cost or the Jacobian, from one thread. jacobians: true if the
    // Jacobian is evaluated.
    std::function<void(ConstVectorView x, bool jacobians)> evaluation_callback = {};
    // Creates the caller's own preconditioner, used for PreconditionerKind::kAuto and kProblem. If empty,
    // MakePreconditioner chooses one.
    std::function<std::unique_ptr<Preconditioner<B>>()> make_preconditioner = {};
    // Largest size of a sparse Cholesky factor, and of the Schur complement with the data that form it, in GiB; > 0.
    double max_factor_gib = 4;
    // For residual blocks whose Jacobian is zero for most of their parameter blocks, if these zero blocks change with
    // x. Uses the sparse Cholesky factor, planned again in each linearization without the zero blocks. No parameter
    // block is eliminated.
    bool dynamic_sparsity = false;
  };

  BlockProblem() = default;
  explicit BlockProblem(Options options) : options_(std::move(options)) {}

  // Adds a block of `size` numbers and returns its index: 0, 1, ... The values are 0.
  int AddParameterBlock(int size, std::shared_ptr<const Manifold> manifold = nullptr);
  // The same for a block whose values are in the caller's memory, as in Ceres: `size` numbers that must outlive the
  // block. Get and Gather read them; Set, Scatter and SolveLm(problem) write them.
  int AddParameterBlock(double* values, int size, std::shared_ptr<const Manifold> manifold = nullptr);
  // Removes a parameter block and all residual blocks that use it.
  void RemoveParameterBlock(int block);
  // Sets the manifold of a block; null means a Euclidean block.
  void SetManifold(int block, std::shared_ptr<const Manifold> manifold);
  // A constant block keeps its value during a solve.
  void SetConstant(int block, bool constant = true);
  // Sets bounds of one entry of a block; lower <= upper, and an infinity means no bound. Equal bounds keep the entry at
  // that value. If the block has a manifold, each step is first taken on the manifold, then the new values are clamped
  // to the bounds.
  void SetBounds(int block, int entry, double lower, double upper);
  // Adds the term 1/2 rho(s) to the cost, where s is the squared norm of the residuals. A null loss means rho(s) = s.
  // blocks: indices of the parameter blocks, without repeats. Their number and sizes must match cost->block_sizes().
  // Returns the index of the residual block: 0, 1, ...
  Index AddResidualBlock(std::shared_ptr<const CostFunction> cost, std::shared_ptr<const Loss> loss,
                         std::span<const int> blocks);
  Index AddResidualBlock(std::shared_ptr<const CostFunction> cost, std::shared_ptr<const Loss> loss,
                         std::initializer_list<int> blocks) {
    return AddResidualBlock(std::move(cost), std::move(loss), std::span(blocks.begin(), blocks.size()));
  }
  // Adds one residual block per cost function, as AddResidualBlock does. Returns the indices of the residual blocks.
  // The problem keeps `costs`, so the cost functions need no separate memory allocations. Cost: a type that can be
  // moved, such as AutoDiffCost. blocks: the parameter blocks of all residual blocks, one after another.
  template <std::derived_from<CostFunction> Cost>
  std::vector<Index> AddResidualBlocks(std::vector<Cost> costs, std::span<const int> blocks,
                                       const std::shared_ptr<const Loss>& loss = nullptr) {
    const auto owner = std::make_shared<const std::vector<Cost>>(std::move(costs));
    std::vector<const CostFunction*> pointers;
    pointers.reserve(owner->size());
    for (const Cost& cost : *owner) pointers.push_back(&cost);
    return AddAll(owner, pointers, blocks, loss);
  }
  void RemoveResidualBlock(Index residual_block);

  // Reserves memory for `count` residual blocks in total.
  void ReserveResidualBlocks(std::size_t count);

  // Replaces Options::evaluation_callback.
  void set_evaluation_callback(std::function<void(ConstVectorView x, bool jacobians)> callback) {
    options_.evaluation_callback = std::move(callback);
  }

  // Numbers of blocks, and the indices of blocks in ascending order. Removed blocks are left out.
  int num_parameter_blocks() const { return num_parameter_blocks_; }
  Index num_residual_blocks() const { return static_cast<Index>(residuals_.size() - residuals_.num_empty()); }
  std::vector<int> parameter_blocks() const;
  std::vector<Index> residual_blocks() const;
  bool has_parameter_block(int block) const;
  bool has_residual_block(Index residual_block) const;
  // The arguments of AddParameterBlock, SetManifold, SetConstant and SetBounds.
  int parameter_block_size(int block) const { return Parameter(block).ambient_size; }
  const std::shared_ptr<const Manifold>& manifold(int block) const;
  bool is_constant(int block) const;
  double lower_bound(int block, int entry) const;
  double upper_bound(int block, int entry) const;
  // Index of the block with these values in the caller's memory. Throws Error if there is none.
  int FindParameterBlock(const double* values) const;
  // The arguments of AddResidualBlock. The span is valid until a residual block is added or removed.
  const std::shared_ptr<const CostFunction>& cost_function(Index residual_block) const;
  const std::shared_ptr<const Loss>& loss(Index residual_block) const;
  std::span<const int> parameter_blocks_of(Index residual_block) const;
  // Indices of the residual blocks that use a parameter block, in ascending order. The first call after a residual
  // block was added visits all residual blocks.
  std::vector<Index> residual_blocks_of(int block) const;

  // The value of a block, in the memory of the problem or of the caller. Valid until a parameter block is added.
  std::span<const double> Get(int block) const;
  // Copies parameter_block_size(block) numbers.
  void Set(int block, const double* values);
  // The values of all blocks as x, and the reverse. Entries of removed blocks are 0.
  B::Vector Gather() const;
  void Scatter(ConstVectorView x);

  // Position of the block's first number in x.
  Index offset(int block) const { return Parameter(block).ambient_offset; }
  // Position of the block's first entry in a step, and the block's number of entries; -1 and 0 for constant blocks and
  // for blocks that no residual block uses.
  Index tangent_offset(int block);
  int tangent_size(int block);

  Index num_parameters() const override { return num_parameters_; }
  Index num_tangent() const override { return Structure().num_tangent(); }
  // The cost of all residual blocks.
  double Cost(ConstVectorView x) override;
  // FixedCost: the cost of residual blocks without a free block. VariableCost: the cost of the other residual blocks.
  double FixedCost(ConstVectorView x) override;
  double VariableCost(ConstVectorView x) override;
  double VariableNorm(ConstVectorView x) override;
  double VariableMaxChange(ConstVectorView x, VectorView y) override;
  // A unit is a residual block with a free block. Units have the order of the residual blocks.
  Index num_units() const override { return static_cast<Index>(Structure().rows().size()); }
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // Returns the caller's own preconditioner if Options::make_preconditioner is set. Otherwise returns the sparse
  // Cholesky factor if it stays within max_factor_gib and is estimated to be faster than PCG with block Jacobi
  // (solver/internal/normal_equations/step_cost.h). Otherwise returns block Jacobi.
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override;
  // Returns the sparse Cholesky factor, even if it is slow. Throws Error if it would be larger than max_factor_gib.
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() override;
  // Returns operation counts of one solver step, for LinearSolverKind::kAuto. eliminating: count for the Schur
  // complement, if the problem has blocks to eliminate. Null if the caller provides a preconditioner.
  const StepCounts* CountSteps(bool eliminating) override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;
  bool has_bounds() const override { return !lower_.empty(); }
  bool IsFeasible(ConstVectorView x) override { return DescribeInfeasible(x).empty(); }
  void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) override;
  void ClipStep(ConstVectorView x, VectorView step) override;
  // Texts for error messages. They name parameter blocks and residual blocks by index, from 0 in the order in which
  // they were added. A description is empty if no fault was found.
  std::string NameTangent(Index k) override;
  std::string NameResidual(int batch, Index row) override;
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override;
  std::string DescribeInfeasible(ConstVectorView x) override;
  std::string DescribeDegenerate(ConstVectorView x) override;

 private:
  friend class BlockLinearization;
  friend class BlockParts;
  friend class BlockEvaluator;
  struct Term {
    std::shared_ptr<const CostFunction> cost;
    std::shared_ptr<const Loss> loss;
  };
  // Buffers of the previous linearization, which the next one reuses. Their old contents are not read.
  struct LinearizationMemory {
    B::Vector jacobian, residuals, product;
  };
  const ParameterBlock& Parameter(int block) const;
  std::vector<Index> AddAll(const std::shared_ptr<const void>& owner, std::span<const CostFunction* const> costs,
                            std::span<const int> blocks, const std::shared_ptr<const Loss>& loss);
  // The position of a residual block in residuals_ and terms_.
  std::size_t CheckedTerm(Index residual_block) const;
  // Position of an entry of a block in x.
  std::size_t EntryOf(int block, int entry) const;
  // Discards all data that depend on the structure of the problem.
  void Changed();
  const BlockStructure& Structure() const;
  BlockNormalMatrix& NormalMatrix() const;
  const Couplings& EliminatedCouplings() const;
  // Lower bound on the operation counts of a sparse Cholesky factor of H. Does not plan the factorisation.
  StepCounts::Factor LeastFactor() const;
  // max_factor_gib in bytes. Throws Error if it is not positive.
  double MaxFactorBytes() const;
  // Plans the sparse Cholesky factorisation. Returns null if the factor would exceed max_factor_gib or need more than
  // max_multiplications. In this case, the function sets `exceeded`, if not null, to the limit that would be exceeded.
  std::shared_ptr<SparseCholesky> PlanCholesky(double max_multiplications, ExceededLimit* exceeded = nullptr) const;
  // Plans the Cholesky factor of the reduced system. Returns null if PCG with Schur-Jacobi is preferred
  // (FactorBeatsIterations). If `always` is true, it plans even a slow factor, and throws Error if the factor would
  // exceed max_factor_gib.
  std::shared_ptr<ReducedMatrixPlan> PlanReduced(bool always);
  // Returns the plan. Throws Error that max_factor_gib is too small if it is null.
  template <class Plan>
  std::shared_ptr<Plan> Planned(std::shared_ptr<Plan> plan) const;
  // Work memory for evaluating one residual block, reused for the next.
  struct Scratch {
    std::vector<const double*> arguments;
    std::vector<double*> jacobians;  // per argument, in ambient coordinates; null for constant blocks
    std::vector<double> residuals;
    std::vector<double> ambient;        // memory of `jacobians`, one after another
    std::vector<double> plus_jacobian;  // Manifold::PlusJacobian of one parameter block
  };
  // For residual block `term`: sets scratch.arguments to its parameter blocks in x, and fills the residuals with
  // Unwritten, a NaN that marks entries which the cost function does not write.
  void Prepare(ConstVectorView x, std::size_t term, double* residuals, Scratch& scratch) const;
  // Computes the residuals and Jacobians of a residual block. Both are filled with Unwritten first. Returns the cost
  // function's return value.
  bool EvaluateTerm(ConstVectorView x, std::size_t term, double* residuals, Scratch& scratch) const;
  // Computes the residuals of a residual block, and its Jacobian in the tangent spaces of the free blocks `cells`.
  // Applies no losses. The Jacobian is row-major, with `width` columns. If the cost function returns false, the
  // residuals are NaN, and the Jacobian is not written.
  void LinearizeTerm(ConstVectorView x, std::size_t term, std::span<const BlockCell> cells, int width,
                     double* residuals, double* jacobian, Scratch& scratch) const;
  // Writes the residuals to scratch.residuals; NaN if they are undefined.
  double TermCost(ConstVectorView x, std::size_t term, Scratch& scratch) const;
  // Describes the first value of a residual block that is not finite; empty if all are finite.
  std::string DescribeTerm(ConstVectorView x, std::size_t term, bool jacobians, Scratch& scratch) const;
  // Sums the costs of the residual blocks term_of(0), ..., term_of(count - 1).
  template <class TermOf>
  double SumCosts(ConstVectorView x, Index count, const TermOf& term_of) const;
  // Sums of(i) over the entries i of x that belong to free blocks.
  template <class T, class Of>
  T SumVariable(const Of& of) const;
  // Calls visit(index in x, index in the step) for each free entry without a manifold, if the problem has bounds.
  template <class Visit>
  void VisitEuclidean(const Visit& visit) const;

  Options options_;
  Index num_parameters_ = 0;
  int num_parameter_blocks_ = 0;
  std::vector<ParameterBlock> parameters_;
  std::vector<std::shared_ptr<const Manifold>> manifolds_;
  std::vector<bool> constant_;
  std::unordered_map<int, std::vector<int>> removed_;  // indices of removed parameter blocks, by their size
  std::vector<double> values_;                         // of the parameter blocks outside of the caller's memory
  std::vector<double*> caller_memory_;                 // per parameter block: the caller's memory, or null
  std::unordered_map<const double*, int> block_of_;    // the parameter blocks in the caller's memory
  ResidualBlockList residuals_;
  std::vector<Term> terms_;
  // Per parameter block: its residual blocks, including removed ones. Empty after a residual block was added.
  mutable std::vector<std::vector<Index>> users_;
  std::vector<double> lower_, upper_;  // one entry per entry of x; empty if there are no bounds
  mutable std::optional<BlockStructure> structure_;
  mutable LinearizationMemory memory_;
  // The structure of H = J^T J, the plan of its Cholesky factor, and the memory of both. All linearizations share them.
  mutable std::shared_ptr<BlockNormalMatrix> normal_matrix_;
  std::shared_ptr<SparseCholesky> cholesky_;
  // The same for the reduced system.
  mutable std::shared_ptr<const Couplings> couplings_;
  std::shared_ptr<ReducedMatrixPlan> reduced_matrix_;
  std::optional<StepCounts> counts_;
};

// Minimises the cost from the values that the problem keeps (BlockProblem::Gather), and replaces these values by the
// best ones found. Otherwise like the other overloads (solver/levenberg_marquardt.h).
LmSummary SolveLm(BlockProblem& problem, const LmOptions& options = {},
                  const IterationCallback<CpuBackend<double>>& callback = {});

}  // namespace vesta
