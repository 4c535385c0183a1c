// Default bodies of the problem interfaces.
#pragma once

#include "kernels/core/check.h"
#include "solver/normal_equations/preconditioner.h"
#include "solver/normal_equations/reduced_system.h"
#include "solver/normal_equations/sharded_system.h"
#include "solver/problem.h"

namespace vesta {

template <Backend B>
void Linearization<B>::Descent(VectorView d) {
  Gradient(d);
  B().Axpby(-1.0, d, 0.0, d);
}

template <Backend B>
void Linearization<B>::SquaredGradients(VectorView) {
  Fail("a linearization whose descent is its own must define SquaredGradients() to be a part of a problem");
}

template <Backend B>
void Linearization<B>::DescentOf(Index, ConstVectorView, VectorView) const {
  Fail("a linearization whose descent is its own must define DescentOf() to be a part of a problem");
}

template <Backend B>
void Linearization<B>::ApplyW(ConstVectorView u, VectorView Wu) {
  B().Copy(u, Wu);
}

template <Backend B>
void Linearization<B>::ApplyH(ConstVectorView v, VectorView Hv) {
  if (work_u_.size() != num_residuals()) {
    work_u_.Resize(num_residuals());
    work_Wu_.Resize(num_residuals());
  }
  ApplyJ(v, work_u_);
  ApplyW(work_u_, work_Wu_);
  ApplyJT(work_Wu_, Hv);
}

template <Backend B>
double Linearization<B>::Curvature(ConstVectorView v) {
  typename B::Vector Hv(num_parameters());
  ApplyH(v, Hv);
  return B().Dot(v, Hv);
}

template <Backend B>
void Linearization<B>::BlockGram(BlockDiagonal<B>&) {
  Fail("a linearization with block_groups() must define BlockGram()");
}

template <Backend B>
std::unique_ptr<ReducedSystem<B>> Linearization<B>::MakeReducedSystem() {
  return nullptr;
}

template <Backend B>
std::unique_ptr<ShardedSystem<B>> Linearization<B>::MakeShardedSystem() {
  return nullptr;
}

template <Backend B>
std::unique_ptr<Preconditioner<B>> Problem<B>::MakePreconditioner() {
  return nullptr;
}

template <Backend B>
std::unique_ptr<Preconditioner<B>> Problem<B>::MakeSparseCholesky() {
  return nullptr;
}

template <Backend B>
const StepCounts* Problem<B>::CountSteps(bool) {
  return nullptr;
}

template <Backend B>
double Problem<B>::Cost(ConstVectorView x, std::span<const Index> units) {
  VESTA_CHECK(static_cast<Index>(units.size()) == num_units(),
              "cost over {} of {} units: the problem must define Cost(x, units)", units.size(), num_units());
  return Cost(x);
}

template <Backend B>
bool Problem<B>::IsFeasible(ConstVectorView) {
  return true;
}

template <Backend B>
void Problem<B>::MaskActiveBounds(ConstVectorView, ConstVectorView, VectorView) {}

template <Backend B>
void Problem<B>::ClipStep(ConstVectorView, VectorView) {}

template <Backend B>
void Problem<B>::BeginTurn(int) {}

template <Backend B>
std::string Problem<B>::NameTangent(Index k) {
  return fmt::format("entry {} of the step", k);
}

template <Backend B>
std::string Problem<B>::NameResidual(int batch, Index row) {
  return num_batches() == 1 ? fmt::format("residual {}", row) : fmt::format("residual {} of batch {}", row, batch);
}

template <Backend B>
std::string Problem<B>::DescribeNonFinite(ConstVectorView, bool) {
  return "";
}

template <Backend B>
std::string Problem<B>::DescribeInfeasible(ConstVectorView) {
  return "";
}

template <Backend B>
std::string Problem<B>::DescribeDegenerate(ConstVectorView) {
  return "";
}

template <Backend B>
std::unique_ptr<Linearization<B>> Problem<B>::CheckedLinearize(ConstVectorView x, int batch) {
  CheckSize(x);
  auto linearization = Linearize(x, batch);
  if (!linearization) Fail("Linearize of batch {} gave null; it must give a linearization at every x", batch);
  if (linearization->num_parameters() != num_tangent()) {
    Fail("the linearization of batch {} has {} columns, a step of the problem {} entries; make them the same", batch,
         linearization->num_parameters(), num_tangent());
  }
  return linearization;
}

template <Backend B>
void Problem<B>::CheckSize(ConstVectorView x) const {
  if (x.size() != num_parameters()) {
    Fail("x has {} entries, the problem {} parameters; give x one entry a parameter", x.size(), num_parameters());
  }
}

template <Backend B>
void Problem<B>::CheckBatch(int batch) const {
  if (batch < 0 || batch >= num_batches()) Fail("batch {} of {}; they count from 0", batch, num_batches());
}

template <Backend B>
void Problem<B>::CheckUnits(std::span<const Index> units) const {
  for (const Index unit : units) {
    if (unit < 0 || unit >= num_units()) Fail("unit {} of {}; they count from 0", unit, num_units());
  }
}

template <Backend B>
bool Problem<B>::DampingMetric(ConstVectorView, ConstVectorView, VectorView) {
  return false;
}

template <Backend B>
void Problem<B>::Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) {
  backend.Copy(x, out);
  backend.Axpby(1.0, delta, 1.0, out);
}

}  // namespace vesta
