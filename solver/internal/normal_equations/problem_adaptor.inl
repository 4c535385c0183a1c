// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/problem_adaptor.h.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <typeinfo>
#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/reduced_system.h"

namespace vesta {

namespace adaptor_internal {

inline constexpr std::ptrdiff_t kNone = std::numeric_limits<std::ptrdiff_t>::min();

template <class Interface, class Base>
std::ptrdiff_t OffsetOf(Base& object, const char* whole) {
  auto* const found = dynamic_cast<Interface*>(&object);
  return found ? reinterpret_cast<const char*>(found) - whole : kNone;
}

// Pointers to the interfaces of an object; null for a missing interface. In all objects of a class, an interface has
// the same offset. So each thread searches again only if the class is not the class of the previous object. Otherwise a
// dozen dynamic_casts would take a tenth of the time of a linearization of two parameters.
template <class... Interfaces, class Base>
std::tuple<Interfaces*...> FindInterfaces(Base& object) {
  thread_local const std::type_info* last = nullptr;
  thread_local std::array<std::ptrdiff_t, sizeof...(Interfaces)> offsets{};
  char* const whole = static_cast<char*>(dynamic_cast<void*>(&object));
  if (const std::type_info* const type = &typeid(object); type != last) {
    offsets = {OffsetOf<Interfaces>(object, whole)...};
    last = type;
  }
  auto offset = offsets.begin();
  const auto next = [&] {
    const std::ptrdiff_t at = *offset++;
    return at == kNone ? nullptr : whole + at;
  };
  return std::tuple<Interfaces*...>{reinterpret_cast<Interfaces*>(next())...};
}

}  // namespace adaptor_internal

template <Backend B>
LinearizationAdaptor<B>::LinearizationAdaptor(Linearization<B>& linearization) : linearization_(linearization) {
  std::tie(gradient_, weights_, product_, blocks_, reduced_, sharded_, rhs_, stored_) =
      adaptor_internal::FindInterfaces<WithGradient<B>, WithLossWeights<B>, WithProductH<B>, WithBlocks<B>,
                                       WithReducedSystem<B>, WithShardedSystem<B>, WithOwnRightHandSide<B>,
                                       WithStoredJacobian>(linearization);
}

template <Backend B>
LinearizationAdaptor<B>::LinearizationAdaptor(std::unique_ptr<Linearization<B>> linearization)
    : LinearizationAdaptor(*linearization) {
  owned_ = std::move(linearization);
}

template <Backend B>
void LinearizationAdaptor<B>::ApplyThreeProducts(ConstVectorView v, VectorView Hv) {
  if (work_u_.size() != num_residuals()) {
    work_u_.Resize(num_residuals());
    work_Wu_.Resize(num_residuals());
  }
  ApplyJ(v, work_u_);
  ApplyW(work_u_, work_Wu_);
  ApplyJT(work_Wu_, Hv);
}

template <Backend B>
double LinearizationAdaptor<B>::Curvature(ConstVectorView v) {
  if (product_) return product_->Curvature(v);
  typename B::Vector Hv(num_parameters());
  ApplyThreeProducts(v, Hv);
  return B().Dot(v, Hv);
}

template <Backend B>
std::unique_ptr<ReducedSystem<B>> LinearizationAdaptor<B>::MakeReducedSystem() {
  return reduced_ ? reduced_->MakeReducedSystem() : nullptr;
}

template <Backend B>
std::unique_ptr<ShardedSystem<B>> LinearizationAdaptor<B>::MakeShardedSystem() {
  return sharded_ ? sharded_->MakeShardedSystem() : nullptr;
}

template <Backend B>
void LinearizationAdaptor<B>::RightHandSide(VectorView d) {
  if (has_own_right_hand_side()) return rhs_->RightHandSide(d);
  Gradient(d);
  B().Axpby(-1.0, d, 0.0, d);
}

template <Backend B>
ProblemAdaptor<B>::ProblemAdaptor(Problem<B>* problem) : problem_(problem) {
  if (!problem) return;
  std::tie(manifold_, fixed_, units_, batches_, bounds_, metric_, preconditioner_, cholesky_, counts_, collective_,
           names_, describes_) =
      adaptor_internal::FindInterfaces<OnManifold<B>, WithFixedCost<B>, InUnits<B>, InBatches<B>, WithBounds<B>,
                                       WithDampingMetric<B>, WithPreconditioner<B>, WithSparseCholesky<B>,
                                       WithStepCounts, Collective, WithNames, Describes<B>>(*problem);
}

template <Backend B>
void ProblemAdaptor<B>::Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) const {
  if (manifold_) return manifold_->Plus(backend, x, delta, out);
  backend.Copy(x, out);
  backend.Axpby(1.0, delta, 1.0, out);
}

template <Backend B>
double ProblemAdaptor<B>::VariableNorm(B& backend, ConstVectorView x) const {
  return fixed_ ? fixed_->VariableNorm(x) : std::sqrt(backend.Dot(x, x));
}

template <Backend B>
double ProblemAdaptor<B>::VariableMaxChange(B& backend, ConstVectorView x, VectorView y) const {
  if (fixed_) return fixed_->VariableMaxChange(x, y);
  backend.Axpby(-1.0, x, 1.0, y);
  return backend.MaxAbs(y);
}

template <Backend B>
double ProblemAdaptor<B>::Cost(ConstVectorView x, std::span<const Index> units) const {
  if (units_) return units_->Cost(x, units);
  VESTA_CHECK(units.size() == 1, "the cost of {} units was requested, but the problem does not derive from InUnits",
              units.size());
  return VariableCost(x);
}

template <Backend B>
std::unique_ptr<LinearizationAdaptor<B>> ProblemAdaptor<B>::CheckedLinearize(ConstVectorView x, int batch) const {
  if (x.size() != num_parameters()) {
    Fail(kBadArgument, "x has {} entries, but the problem has {} parameters; give x one entry per parameter", x.size(),
         num_parameters());
  }
  auto linearization = Linearize(x, batch);
  if (!linearization)
    Fail(kBadArgument, "Linearize of batch {} returned null; it must return a linearization at every x", batch);
  if (linearization->num_parameters() != num_tangent()) {
    Fail(kBadArgument,
         "the linearization of batch {} has {} columns, but a step of the problem has {} entries; make them equal",
         batch, linearization->num_parameters(), num_tangent());
  }
  return std::make_unique<LinearizationAdaptor<B>>(std::move(linearization));
}

template <Backend B>
std::unique_ptr<Preconditioner<B>> ProblemAdaptor<B>::MakePreconditioner() const {
  return preconditioner_ ? preconditioner_->MakePreconditioner() : nullptr;
}

template <Backend B>
std::unique_ptr<Preconditioner<B>> ProblemAdaptor<B>::MakeSparseCholesky() const {
  return cholesky_ ? cholesky_->MakeSparseCholesky() : nullptr;
}

template <Backend B>
std::string ProblemAdaptor<B>::NameTangent(Index k) const {
  std::string name = names_ ? names_->NameTangent(k) : "";
  return name.empty() ? fmt::format("entry {} of the step", k) : name;
}

template <Backend B>
std::string ProblemAdaptor<B>::NameResidual(int batch, Index row) const {
  if (std::string name = names_ ? names_->NameResidual(batch, row) : ""; !name.empty()) return name;
  return num_batches() == 1 ? fmt::format("residual {}", row) : fmt::format("residual {} of batch {}", row, batch);
}

template <Backend B>
std::string ProblemAdaptor<B>::DescribeNonFinite(ConstVectorView x, bool jacobians) const {
  return describes_ ? describes_->DescribeNonFinite(x, jacobians) : "";
}

template <Backend B>
std::string ProblemAdaptor<B>::DescribeInfeasible(ConstVectorView x) const {
  return describes_ ? describes_->DescribeInfeasible(x) : "";
}

template <Backend B>
std::string ProblemAdaptor<B>::DescribeDegenerate(ConstVectorView x) const {
  return describes_ ? describes_->DescribeDegenerate(x) : "";
}

template <Backend B>
void ToHost(B& backend, typename B::ConstVectorView from, double* to) {
  if constexpr (std::is_same_v<typename B::Space, Host>) {
    std::copy(from.begin(), from.end(), to);
  } else {
    std::vector<typename B::Scalar> host(static_cast<std::size_t>(from.size()));
    backend.ToHost(from, {host.data(), from.size()});
    std::copy(host.begin(), host.end(), to);
  }
}

template <Backend B>
void FromHost(B& backend, const double* from, typename B::VectorView to) {
  using S = typename B::Scalar;
  const auto convert = [](double value) { return static_cast<S>(value); };
  if constexpr (std::is_same_v<typename B::Space, Host>) {
    std::transform(from, from + to.size(), to.begin(), convert);
  } else {
    std::vector<S> host(static_cast<std::size_t>(to.size()));
    std::transform(from, from + to.size(), host.begin(), convert);
    backend.FromHost({host.data(), to.size()}, to);
  }
}

template <Backend B>
DenseJacobian MakeDenseJacobian(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView mask) {
  const Index cols = batches.front()->num_parameters();
  Index rows = 0;
  for (const LinearizationAdaptor<B>* batch : batches) rows += batch->num_residuals();
  VESTA_CHECK(rows <= std::numeric_limits<int>::max() && cols <= std::numeric_limits<int>::max(),
              "a dense Jacobian of {} x {}", rows, cols);
  DenseJacobian dense{.rows = static_cast<int>(rows), .cols = static_cast<int>(cols)};
  dense.residuals.resize(static_cast<std::size_t>(rows));
  dense.jacobian.resize(static_cast<std::size_t>(rows * cols));
  std::vector<double> moves(static_cast<std::size_t>(mask.size()));
  ToHost(backend, mask, moves.data());
  typename B::Vector unit, column;
  Index row = 0;
  for (LinearizationAdaptor<B>* batch : batches) {
    const Index batch_rows = batch->num_residuals();
    ToHost(backend, batch->residuals(), dense.residuals.data() + row);
    const WithStoredJacobian* const stored = batch->stored_jacobian();
    if (stored) {
      stored->CopyJacobian(dense.jacobian.data() + row, rows);
    } else {
      unit.Resize(cols);
      column.Resize(batch_rows);
    }
    for (Index k = 0; k < cols; ++k) {
      double* const to = dense.jacobian.data() + k * rows + row;
      if (!moves.empty() && moves[static_cast<std::size_t>(k)] == 0) {
        std::fill_n(to, batch_rows, 0.0);
      } else if (!stored) {
        backend.Fill(1, unit.view().subspan(k, 1));
        batch->ApplyJ(unit, column);
        backend.Fill(0, unit.view().subspan(k, 1));
        ToHost<B>(backend, column, to);
      }
    }
    row += batch_rows;
  }
  return dense;
}

}  // namespace vesta
