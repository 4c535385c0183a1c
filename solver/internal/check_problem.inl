// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/check_problem.h.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "solver/check_problem.h"
#include "solver/compose.h"
#include "solver/internal/derivative_check.inl"

namespace vesta {

namespace check_internal {

template <Backend B>
class ProblemChecker {
 public:
  using S = typename B::Scalar;
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;
  using Vector = typename B::Vector;
  static constexpr bool kDouble = sizeof(S) == sizeof(double);

  ProblemChecker(B& backend, ProblemAdaptor<B> problem, ConstVectorView x, const CheckProblemOptions& options)
      : backend_(backend), problem_(problem), x_(x), options_(options), n_(problem.num_tangent()) {
    if (options_.max_columns < 1) Fail(kBadArgument, "max_columns is {}; choose 1 or more", options_.max_columns);
    stride_ = std::max<Index>(1, (n_ + options_.max_columns - 1) / options_.max_columns);
    if (options_.rounding == 0) options_.rounding = kDouble ? 1e-8 : 1e-3;
    if (options_.derivatives == 0) options_.derivatives = kDouble ? 1e-5 : 1e-2;
  }

  ProblemCheck Run() {
    try {
      problem_.OnNewPoint(0);
      if (n_ > 0 && CheckCost() && CheckPlus()) CheckLinearizations();
    } catch (const Error& error) {
      Add("{}", error.what());
    }
    return {std::move(faults_)};
  }

 private:
  template <class... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    faults_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
  std::vector<double> OnHost(ConstVectorView v) const {
    std::vector<S> host(static_cast<std::size_t>(v.size()));
    backend_.ToHost(v, {host.data(), v.size()});
    return {host.begin(), host.end()};
  }
  double Norm(ConstVectorView v) const { return std::sqrt(backend_.Dot(v, v)); }
  Vector Random(Index size, std::uint64_t seed) const {
    Vector v(size);
    FillRandom<B>(backend_, seed, v.view());
    return v;
  }
  Vector Unit(Index k, double length = 1) const {
    Vector v(n_);
    backend_.Fill(length, v.view().subspan(k, 1));
    return v;
  }
  // Calls `write` on entries filled with NaN. If an entry is not finite afterwards, adds a fault that names it, and
  // returns false.
  template <class Write, class Name>
  bool Written(const char* what, VectorView out, const Write& write, const Name& name) {
    backend_.Fill(std::numeric_limits<double>::quiet_NaN(), out);
    write(out);
    if (backend_.AllFinite(out)) return true;
    const std::vector<double> host = OnHost(out);
    const auto bad = std::find_if(host.begin(), host.end(), [](double value) { return !std::isfinite(value); });
    Add("{} leaves {} {}; it must overwrite every entry", what, name(static_cast<Index>(bad - host.begin())),
        std::isnan(*bad) ? "NaN, or does not write it" : "infinite");
    return false;
  }
  // Adds a fault if a and b, which should be equal, differ by more than rounding.
  template <class Name>
  void Same(const char* what, ConstVectorView a, ConstVectorView b, const Name& name) {
    Vector difference(a.size());
    backend_.Copy(a, difference);
    backend_.Axpby(-1.0, b, 1.0, difference);
    const double scale = std::max(Norm(a), Norm(b));
    if (Norm(difference.view()) <= options_.rounding * scale) return;
    const std::vector<double> at = OnHost(difference.view());
    const auto worst =
        std::max_element(at.begin(), at.end(), [](double p, double q) { return std::abs(p) < std::abs(q); });
    const auto k = static_cast<std::size_t>(worst - at.begin());
    Add("{}: they differ by {:.2g} of their norm, most at {}, with values {:.6g} and {:.6g}", what,
        Norm(difference.view()) / scale, name(static_cast<Index>(k)), OnHost(a)[k], OnHost(b)[k]);
  }
  bool Far(double a, double b) const {
    return std::abs(a - b) > options_.rounding * std::max(std::abs(a), std::abs(b));
  }

  bool CheckCost();
  bool CheckPlus();
  void CheckLinearizations();
  // Runs the checks that need only one x. Returns false if the other checks would be meaningless.
  bool CheckProducts(int batch, LinearizationAdaptor<B>& linearization);
  void CheckAdjoint(LinearizationAdaptor<B>& linearization, ConstVectorView u);
  void CheckBlocks(LinearizationAdaptor<B>& linearization);

  // Derivative checks, defined in solver/internal/check_problem_derivatives.inl.
  //
  // A function of x (+) t v, with its derivative along v as the problem computes it, for comparison with differences.
  struct Derivative {
    std::function<std::vector<double>(ConstVectorView v)> given;
    std::function<void(ConstVectorView moved, std::span<double> out)> value;
    double length;             // norm of the residuals at x
    ConstVectorView diagonal;  // diagonal of H, for the scale of the parameters
  };
  struct Mismatch {
    Index entry = -1;  // -1: none
    double given = 0, difference = 0;
  };
  // Returns the entry that exceeds the allowed error the most: rounding plus options_.derivatives.
  Mismatch Compare(const Derivative& derivative, ConstVectorView v) const;
  // Compares along random directions. If there is a mismatch, compares along single entries to find it. `say` adds a
  // fault for an entry of the step, or for -1 if no single entry explains it.
  void CheckDerivative(const Derivative& derivative, const std::function<void(Index k, const Mismatch&)>& say);
  // Random entries, scaled so that each changes the residuals by a similar amount.
  Vector ScaledDirection(ConstVectorView diagonal, std::uint64_t seed) const;
  // Sets entries of v to 0 if a bound would shorten a step of +-length v.
  void DropBounded(double length, Vector& v) const;
  void CheckTangent(int batch, LinearizationAdaptor<B>& linearization);
  void CheckGradient(ConstVectorView gradient, ConstVectorView diagonal);

  B& backend_;
  ProblemAdaptor<B> problem_;
  ConstVectorView x_;
  CheckProblemOptions options_;
  Index n_, stride_ = 1;
  double cost_ = 0;  // the variable cost (WithFixedCost)
  std::vector<std::string> faults_;
};

template <Backend B>
bool ProblemChecker<B>::CheckCost() {
  if (x_.size() != problem_.num_parameters()) {
    Add("x has {} entries, but the problem has {} parameters", x_.size(), problem_.num_parameters());
    return false;
  }
  const double whole = problem_.Cost(x_), fixed = problem_.FixedCost(x_);
  cost_ = problem_.VariableCost(x_);
  if (!std::isfinite(whole)) {
    Add("Cost is {} at x: {}; choose an x with a finite cost", whole, problem_.DescribeNonFinite(x_, false));
    return false;
  }
  if (const std::string why = problem_.DescribeDegenerate(x_); !why.empty()) Add("{}", why);
  if (const double again = problem_.VariableCost(x_); Far(cost_, again)) {
    Add("Cost gives {:.9g}, and at the same x again {:.9g}; it must depend on x alone", cost_, again);
  } else if (Far(fixed + cost_, whole)) {
    Add("FixedCost and VariableCost are {:.9g} and {:.9g}, and Cost is {:.9g}; make Cost their sum", fixed, cost_,
        whole);
  }
  std::vector<Index> units(static_cast<std::size_t>(problem_.num_units()));
  std::iota(units.begin(), units.end(), Index{0});
  if (const double all = problem_.Cost(x_, units); Far(cost_, all)) {
    Add("Cost over all {} units is {:.9g}, the variable cost {:.9g}; make them the same", units.size(), all, cost_);
  }
  return true;
}

template <Backend B>
bool ProblemChecker<B>::CheckPlus() {
  if (problem_.has_bounds() && !problem_.IsFeasible(x_)) {
    Add("x violates a bound; choose one inside");
    return false;
  }
  const auto name = [](Index i) { return fmt::format("entry {} of x", i); };
  Vector moved(problem_.num_parameters()), step(n_);
  if (!Written(
          "Plus", moved.view(), [&](VectorView out) { problem_.Plus(backend_, x_, step, out); }, name))
    return false;
  Same("x and Plus(x, 0) must be the same", x_, moved.view(), name);
  const double length = 1e-3 * std::max(1.0, backend_.MaxAbs(x_));
  for (Index k = 0; k < n_; k += stride_) {
    bool moves = false;
    for (const double sign : {1.0, -1.0}) {
      const Vector unit = Unit(k, sign * length);
      problem_.Plus(backend_, x_, unit, moved.view());
      backend_.Axpby(-1.0, x_, 1.0, moved);
      moves = moves || backend_.MaxAbs(moved.view()) > 0;
    }
    if (!moves) {
      Add("Plus does not move x along {}; every entry of a step must", problem_.NameTangent(k));
      break;
    }
  }
  step = Random(n_, 1);
  backend_.Axpby(length, step, 0.0, step);
  if (!Written(
          "Plus", moved.view(), [&](VectorView out) { problem_.Plus(backend_, x_, step, out); }, name))
    return false;
  if (!problem_.IsFeasible(moved)) Add("Plus leads out of the bounds; it must project onto them");
  return true;
}

template <Backend B>
void ProblemChecker<B>::CheckLinearizations() {
  Vector gradient(n_), diagonal(n_), part(n_);
  double squares = 0;
  bool plain = true;
  for (int batch = 0; batch < problem_.num_batches(); ++batch) {
    const auto linearization = problem_.CheckedLinearize(x_, batch);
    if (!CheckProducts(batch, *linearization)) return;
    linearization->Gradient(part);
    backend_.Axpby(1.0, part, 1.0, gradient);
    linearization->DiagJTJ(part);
    backend_.Axpby(1.0, part, 1.0, diagonal);
    squares += 0.5 * backend_.Dot(linearization->residuals(), linearization->residuals());
    plain = plain && !linearization->weighted();
  }
  // If there is a loss, J is not the derivative of the residuals corrected for it.
  plain = plain && std::abs(squares - cost_) <= (kDouble ? 1e-9 : 1e-4) * cost_;
  const std::size_t before = faults_.size();
  for (int batch = 0; plain && batch < problem_.num_batches(); ++batch) {
    CheckTangent(batch, *problem_.CheckedLinearize(x_, batch));
  }
  // A wrong J also makes the gradient wrong. Report that as one fault.
  if (faults_.size() == before) CheckGradient(gradient, diagonal);
}

template <Backend B>
bool ProblemChecker<B>::CheckProducts(int batch, LinearizationAdaptor<B>& linearization) {
  const Index rows = linearization.num_residuals();
  if (linearization.residuals().size() != rows) {
    Add("residuals() has {} entries, num_residuals() is {}; make them the same", linearization.residuals().size(),
        rows);
    return false;
  }
  if (!backend_.AllFinite(linearization.residuals())) {
    const std::string where = problem_.DescribeNonFinite(x_, true);
    Add("residuals of batch {} are not finite though Cost is{}{}", batch, where.empty() ? "" : ": ", where);
    return false;
  }
  const auto entry = [&](Index k) { return problem_.NameTangent(k); };
  const auto residual = [&](Index row) { return problem_.NameResidual(batch, row); };
  const Vector v = Random(n_, 2), u = Random(rows, 3);
  Vector Jv(rows), Wu(rows), WJv(rows), g(n_), Hv(n_), other(n_);
  bool written = Written(
      "ApplyJ", Jv.view(), [&](VectorView out) { linearization.ApplyJ(v, out); }, residual);
  written &= Written(
      "ApplyJT", g.view(), [&](VectorView out) { linearization.ApplyJT(u, out); }, entry);
  written &= Written(
      "ApplyW", Wu.view(), [&](VectorView out) { linearization.ApplyW(u, out); }, residual);
  written &= Written(
      "ApplyH", Hv.view(), [&](VectorView out) { linearization.ApplyH(v, out); }, entry);
  written &= Written(
      "DiagJTJ", other.view(), [&](VectorView out) { linearization.DiagJTJ(out); }, entry);
  written &= Written(
      "Gradient", g.view(), [&](VectorView out) { linearization.Gradient(out); }, entry);
  if (!written) {
    const std::string where = problem_.DescribeNonFinite(x_, true);
    if (!where.empty()) faults_.insert(faults_.begin(), where);
    return false;
  }
  CheckAdjoint(linearization, u);
  linearization.ApplyW(Jv, WJv);
  if (const double a = backend_.Dot(Jv, Wu), b = backend_.Dot(u, WJv);
      std::abs(a - b) > options_.rounding * Norm(u) * Norm(WJv)) {
    Add("ApplyW is not symmetric: u^T W v is {:.9g}, v^T W u {:.9g}", b, a);
  }
  if (const double square = backend_.Dot(u, Wu); square < -options_.rounding * Norm(u) * Norm(Wu)) {
    Add("ApplyW is not positive semidefinite: u^T W u is {:.3g} for some u", square);
  }
  linearization.ApplyJT(WJv, other);
  Same("ApplyH(v) and ApplyJT(ApplyW(ApplyJ(v))) must be the same", Hv, other, entry);
  if (const double given = linearization.Curvature(v), exact = backend_.Dot(v, Hv); Far(given, exact)) {
    Add("Curvature(v) is {:.9g}, v^T ApplyH(v) {:.9g}; make them the same", given, exact);
  }
  if (!linearization.weighted()) {
    linearization.ApplyJT(linearization.residuals(), other);
    Same("Gradient and ApplyJT(residuals()) must be the same where weighted() is false", g, other, entry);
  }
  if (!linearization.has_own_right_hand_side()) {
    linearization.RightHandSide(other);
    backend_.Axpby(-1.0, other, 0.0, other);
    Same("-RightHandSide and Gradient must be the same where has_own_right_hand_side() is false", other, g, entry);
  }
  if (options_.exact_blocks) CheckBlocks(linearization);
  return true;
}

template <Backend B>
void ProblemChecker<B>::CheckAdjoint(LinearizationAdaptor<B>& linearization, ConstVectorView u) {
  JacobianMap<B> jacobian(linearization.get());
  const double error = WorstAdjointError<B>(backend_, jacobian, 4);
  if (error <= options_.rounding) return;
  Vector transposed(n_), column(linearization.num_residuals());
  linearization.ApplyJT(u, transposed);
  const std::vector<double> by_transpose = OnHost(transposed.view());
  Columns<B> columns(backend_, linearization);
  Index worst = -1;
  double largest = 0, by_column = 0;
  for (Index k = 0; k < n_; k += stride_) {
    columns.Column(k, column);
    const double exact = backend_.Dot(u, column.view());
    const double off = RelativeDifference(by_transpose[static_cast<std::size_t>(k)], exact);
    if (off > largest) worst = k, largest = off, by_column = exact;
  }
  Add("ApplyJ and ApplyJT are not adjoint: u^T (J v) and (J^T u)^T v differ by {:.2g} of their size{}", error,
      worst < 0 ? ""
                : fmt::format(", most at {}, where (J^T u) is {:.6g} and u^T (J e) {:.6g}", problem_.NameTangent(worst),
                              by_transpose[static_cast<std::size_t>(worst)], by_column));
}

template <Backend B>
void ProblemChecker<B>::CheckBlocks(LinearizationAdaptor<B>& linearization) {
  const Deviation diagonal = WorstDiagonal(backend_, linearization.get(), Index{0}, stride_);
  if (diagonal.error > options_.rounding) {
    Add("DiagJTJ gives {:.6g} for {}, where its column of J has the weighted square {:.6g}", diagonal.given,
        problem_.NameTangent(diagonal.row), diagonal.exact);
  }
  const std::vector<BlockGroup> groups = linearization.block_groups();
  if (groups.empty()) return;
  Index blocks = 0;
  for (const BlockGroup& group : groups) blocks = std::max(blocks, group.count);
  const Index stride = std::max<Index>(1, (blocks + options_.max_columns - 1) / options_.max_columns);
  const Deviation block = WorstBlock(backend_, linearization.get(), stride);
  if (block.error > options_.rounding) {
    Add("BlockGram gives {:.6g} for {} and {}, where their columns of J have the weighted product {:.6g}", block.given,
        problem_.NameTangent(block.row), problem_.NameTangent(block.col), block.exact);
  }
}

}  // namespace check_internal

template <Backend B>
ProblemCheck CheckProblem(B& backend, Problem<B>& problem, typename B::ConstVectorView x,
                          const CheckProblemOptions& options) {
  return check_internal::ProblemChecker<B>(backend, problem, x, options).Run();
}

}  // namespace vesta

#include "solver/internal/check_problem_derivatives.inl"
