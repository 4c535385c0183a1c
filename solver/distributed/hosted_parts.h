// Parts that are evaluated in another memory space, as parts of the host, which distributed problems are for: their
// vectors are the host's, what an evaluation reads is copied there, and what it makes is copied back. So each process
// may evaluate its parts on a GPU of its own.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/distributed/problem_parts.h"
#include "solver/normal_equations/reduced_system.h"

namespace vesta {

// What the parts of a process keep in B's memory for their vectors.
template <Backend B>
class HostedVectors {
 public:
  using S = typename B::Scalar;
  using Vector = typename B::Vector;

  B& backend() { return backend_; }
  // A copy of v, until the next call; two at the same time by two numbers.
  typename B::View Copy(HostSpan<const S> v, int number = 0) {
    Vector& copy = copies_[number];
    copy.ResizeForOverwrite(v.size());
    backend_.FromHost(v, copy);
    return copy.view();
  }
  // out = what make() writes into a view of that size.
  template <class F>
  void Make(const F& make, HostSpan<S> out) {
    made_.ResizeForOverwrite(out.size());
    make(made_.view());
    backend_.ToHost(std::as_const(made_).view(), out);
  }
  // A copy of x to linearize at. All parts are linearised at the same, so they share one.
  std::shared_ptr<const Vector> CopyOfX(HostSpan<const S> x) {
    std::shared_ptr<const Vector> copy = shared_.lock();
    if (copy && std::equal(x.begin(), x.end(), x_.begin(), x_.end())) return copy;
    auto made = std::make_shared<Vector>();
    made->ResizeForOverwrite(x.size());
    backend_.FromHost(x, *made);
    x_.CopyFrom(x);
    shared_ = made;
    return made;
  }

 private:
  B backend_;
  Vector copies_[2], made_;
  std::weak_ptr<const Vector> shared_;
  HostBuffer<S> x_;  // what shared_ is a copy of
};

// Of a part: borrows the linearization of B's memory that it is of.
template <Backend B>
class HostedReducedSystem final : public ReducedSystem<CpuBackend<typename B::Scalar>> {
 public:
  using Cpu = CpuBackend<typename B::Scalar>;
  using typename ReducedSystem<Cpu>::ConstView;
  using typename ReducedSystem<Cpu>::View;

  HostedReducedSystem(std::shared_ptr<HostedVectors<B>> vectors, std::unique_ptr<ReducedSystem<B>> there)
      : vectors_(std::move(vectors)), there_(std::move(there)) {}

  Index size() const override { return there_->size(); }
  void SetDamping(double lambda, ConstView metric) override { there_->SetDamping(lambda, vectors_->Copy(metric)); }
  void ReduceRhs(ConstView rhs, View reduced) override {
    vectors_->Make([&](auto to) { there_->ReduceRhs(vectors_->Copy(rhs), to); }, reduced);
  }
  void Apply(ConstView x, View y) override {
    vectors_->Make([&](auto to) { there_->Apply(vectors_->Copy(x), to); }, y);
  }
  void BackSubstitute(ConstView rhs, View step) override {
    const auto completed = vectors_->Copy(step, 1);
    there_->BackSubstitute(vectors_->Copy(rhs), completed);
    vectors_->backend().ToHost(completed, step);
  }
  std::vector<BlockGroup> kept_groups() const override { return there_->kept_groups(); }
  void DiagonalBlocks(BlockDiagonal<Cpu>& diagonal) override {
    BlockDiagonal<B> made(size(), diagonal.groups());
    there_->DiagonalBlocks(made);
    vectors_->backend().ToHost(made.all_values(), diagonal.all_values());
  }

 private:
  std::shared_ptr<HostedVectors<B>> vectors_;
  std::unique_ptr<ReducedSystem<B>> there_;
};

template <Backend B>
class HostedLinearization final : public Linearization<CpuBackend<typename B::Scalar>> {
 public:
  using Cpu = CpuBackend<typename B::Scalar>;
  using typename Linearization<Cpu>::ConstView;
  using typename Linearization<Cpu>::View;

  HostedLinearization(std::shared_ptr<HostedVectors<B>> vectors, std::shared_ptr<const typename B::Vector> x,
                      std::unique_ptr<Linearization<B>> there)
      : vectors_(std::move(vectors)), x_(std::move(x)), there_(std::move(there)) {}

  Index num_residuals() const override { return there_->num_residuals(); }
  Index num_parameters() const override { return there_->num_parameters(); }
  ConstView residuals() const override {
    if (residuals_.empty()) {
      residuals_.ResizeForOverwrite(num_residuals());
      vectors_->backend().ToHost(there_->residuals(), residuals_);
    }
    return residuals_;
  }
  void ApplyJ(ConstView v, View u) override {
    Make([&](auto to) { there_->ApplyJ(vectors_->Copy(v), to); }, u);
  }
  void ApplyJT(ConstView u, View g) override {
    Make([&](auto to) { there_->ApplyJT(vectors_->Copy(u), to); }, g);
  }
  void DiagJTJ(View d) override {
    Make([&](auto to) { there_->DiagJTJ(to); }, d);
  }
  void Gradient(View g) override {
    Make([&](auto to) { there_->Gradient(to); }, g);
  }
  bool has_own_descent() const override { return there_->has_own_descent(); }
  void Descent(View d) override {
    Make([&](auto to) { there_->Descent(to); }, d);
  }
  void SquaredGradients(View squares) override {
    Make([&](auto to) { there_->SquaredGradients(to); }, squares);
  }
  void DescentOf(Index units, ConstView gradient, View squares) const override {
    const auto descent = vectors_->Copy(squares, 1);
    there_->DescentOf(units, vectors_->Copy(gradient), descent);
    vectors_->backend().ToHost(descent, squares);
  }
  void ApplyW(ConstView u, View Wu) override {
    Make([&](auto to) { there_->ApplyW(vectors_->Copy(u), to); }, Wu);
  }
  bool weighted() const override { return there_->weighted(); }
  void ApplyH(ConstView v, View Hv) override {
    Make([&](auto to) { there_->ApplyH(vectors_->Copy(v), to); }, Hv);
  }
  double Curvature(ConstView v) override { return there_->Curvature(vectors_->Copy(v)); }
  std::vector<BlockGroup> block_groups() const override { return there_->block_groups(); }
  void BlockGram(BlockDiagonal<Cpu>& blocks) override {
    BlockDiagonal<B> made(num_parameters(), blocks.groups());
    there_->BlockGram(made);
    vectors_->backend().ToHost(made.all_values(), blocks.all_values());
  }
  bool blocks_give_diagonal() const override { return there_->blocks_give_diagonal(); }
  std::unique_ptr<ReducedSystem<Cpu>> MakeReducedSystem() override {
    auto made = there_->MakeReducedSystem();
    return made ? std::make_unique<HostedReducedSystem<B>>(vectors_, std::move(made)) : nullptr;
  }

 private:
  template <class F>
  void Make(const F& make, View out) {
    vectors_->Make(make, out);
  }

  std::shared_ptr<HostedVectors<B>> vectors_;
  std::shared_ptr<const typename B::Vector> x_;
  std::unique_ptr<Linearization<B>> there_;
  mutable HostBuffer<typename B::Scalar> residuals_;
};

template <Backend B>
class HostedProblem final : public Problem<CpuBackend<typename B::Scalar>> {
 public:
  using Cpu = CpuBackend<typename B::Scalar>;
  using typename Problem<Cpu>::ConstView;
  using typename Problem<Cpu>::View;

  HostedProblem(std::shared_ptr<HostedVectors<B>> vectors, Problem<B>& there)
      : vectors_(std::move(vectors)), there_(there) {}
  HostedProblem(std::shared_ptr<HostedVectors<B>> vectors, std::unique_ptr<Problem<B>> there)
      : vectors_(std::move(vectors)), owned_(std::move(there)), there_(*owned_) {}

  Index num_parameters() const override { return there_.num_parameters(); }
  Index num_tangent() const override { return there_.num_tangent(); }
  int num_batches() const override { return there_.num_batches(); }
  Index num_units() const override { return there_.num_units(); }
  double Cost(ConstView x) override { return there_.Cost(vectors_->Copy(x)); }
  double Cost(ConstView x, std::span<const Index> units) override { return there_.Cost(vectors_->Copy(x), units); }
  std::unique_ptr<Linearization<Cpu>> Linearize(ConstView x, int batch) override {
    auto at = vectors_->CopyOfX(x);
    auto made = there_.CheckedLinearize(at->view(), batch);
    return std::make_unique<HostedLinearization<B>>(vectors_, std::move(at), std::move(made));
  }
  void BeginTurn(int turn) override { there_.BeginTurn(turn); }

  bool DampingMetric(ConstView x, ConstView diag_h, View D) override {
    bool is_own = false;
    const auto metric = [&](auto to) {
      is_own = there_.DampingMetric(vectors_->Copy(x), vectors_->Copy(diag_h, 1), to);
      if (!is_own) vectors_->backend().FromHost(D, to);
    };
    vectors_->Make(metric, D);
    return is_own;
  }
  void Plus(Cpu&, ConstView x, ConstView delta, View out) override {
    const auto plus = [&](auto to) {
      there_.Plus(vectors_->backend(), vectors_->Copy(x), vectors_->Copy(delta, 1), to);
    };
    vectors_->Make(plus, out);
  }
  bool has_bounds() const override { return there_.has_bounds(); }
  bool IsFeasible(ConstView x) override { return there_.IsFeasible(vectors_->Copy(x)); }
  std::string DescribeInfeasible(ConstView x) override { return there_.DescribeInfeasible(vectors_->Copy(x)); }
  void MaskActiveBounds(ConstView x, ConstView negative_gradient, View mask) override {
    const auto masked = [&](auto to) {
      vectors_->backend().FromHost(mask, to);
      there_.MaskActiveBounds(vectors_->Copy(x), vectors_->Copy(negative_gradient, 1), to);
    };
    vectors_->Make(masked, mask);
  }
  void ClipStep(ConstView x, View step) override {
    const auto clipped = vectors_->Copy(step, 1);
    there_.ClipStep(vectors_->Copy(x), clipped);
    vectors_->backend().ToHost(clipped, step);
  }
  std::string NameTangent(Index k) override { return there_.NameTangent(k); }
  std::string NameResidual(int batch, Index row) override { return there_.NameResidual(batch, row); }
  std::string DescribeNonFinite(ConstView x, bool jacobians) override {
    return there_.DescribeNonFinite(vectors_->Copy(x), jacobians);
  }
  std::string DescribeDegenerate(ConstView x) override { return there_.DescribeDegenerate(vectors_->Copy(x)); }

 private:
  std::shared_ptr<HostedVectors<B>> vectors_;
  std::unique_ptr<Problem<B>> owned_;
  Problem<B>& there_;
};

template <Backend B>
class HostedParts final : public ProblemParts<CpuBackend<typename B::Scalar>> {
 public:
  using Cpu = CpuBackend<typename B::Scalar>;

  // there must outlive this object and what it makes.
  explicit HostedParts(ProblemParts<B>& there) : there_(there) {
    if (Problem<B>* const whole = there.geometry()) {
      geometry_ = std::make_unique<HostedProblem<B>>(vectors_, *whole);
    }
  }

  int num_parts() const override { return there_.num_parts(); }
  ProblemPart<Cpu> Make(int part) override {
    ProblemPart<B> made = there_.Make(part);
    if (!made.problem) return {};
    return {std::make_unique<HostedProblem<B>>(vectors_, std::move(made.problem)), std::move(made.parameters),
            std::move(made.tangent)};
  }
  Index num_parameters() const override { return there_.num_parameters(); }
  Index num_tangent() const override { return there_.num_tangent(); }
  std::vector<BlockGroup> block_groups() const override { return there_.block_groups(); }
  Problem<Cpu>* geometry() override { return geometry_.get(); }
  bool eliminates() const override { return there_.eliminates(); }

 private:
  ProblemParts<B>& there_;
  std::shared_ptr<HostedVectors<B>> vectors_ = std::make_shared<HostedVectors<B>>();
  std::unique_ptr<HostedProblem<B>> geometry_;
};

}  // namespace vesta
