// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/derivative_check.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "solver/compose.h"
#include "solver/derivative_check.h"
#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

namespace check_internal {

// SplitMix64 hash of a counter (Steele, Lea, Flood, 2014).
inline std::uint64_t Hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

inline double RelativeDifference(double a, double b) {
  const double scale = std::max(std::abs(a), std::abs(b));
  return a == b ? 0 : std::abs(a - b) / std::max(scale, std::numeric_limits<double>::min());
}

// Computes the columns J e_k and W J e_k of a linearization.
template <Backend B>
class Columns {
 public:
  Columns(B& backend, LinearizationAdaptor<B>& linearization)
      : backend_(backend), linearization_(linearization), unit_(linearization.num_parameters()) {}
  // Jk = J e_k.
  void Column(Index k, typename B::Vector& Jk) {
    using S = typename B::Scalar;
    if (Jk.size() != linearization_.num_residuals()) Jk.Resize(linearization_.num_residuals());
    const S one = 1, zero = 0;
    backend_.FromHost({&one, 1}, unit_.view().subspan(k, 1));
    linearization_.ApplyJ(unit_, Jk);
    backend_.FromHost({&zero, 1}, unit_.view().subspan(k, 1));
  }
  // a^T W b on the residual space.
  double WeightedProduct(const typename B::Vector& a, const typename B::Vector& b) {
    if (weighted_.size() != b.size()) weighted_.Resize(b.size());
    linearization_.ApplyW(b.view(), weighted_);
    return backend_.Dot(a.view(), weighted_.view());
  }

 private:
  B& backend_;
  LinearizationAdaptor<B>& linearization_;
  typename B::Vector unit_, weighted_;
};

}  // namespace check_internal

template <Backend B>
void FillRandom(B& backend, std::uint64_t seed, typename B::VectorView x) {
  using S = typename B::Scalar;
  std::vector<S> host(static_cast<std::size_t>(x.size()));
  for (std::size_t k = 0; k < host.size(); ++k) {
    const std::uint64_t bits = check_internal::Hash(check_internal::Hash(seed) + k) >> 11;
    host[k] = static_cast<S>(static_cast<double>(bits) * 0x1p-52 - 1.0);
  }
  backend.FromHost({host.data(), x.size()}, x);
}

template <Backend B>
double AdjointError(B& backend, LinearMap<B>& a, typename B::ConstVectorView u, typename B::ConstVectorView v) {
  typename B::Vector row_terms(a.rows()), column_terms(a.cols());
  a.Apply(v, row_terms);
  a.ApplyAdjoint(u, column_terms);
  const double left = backend.Dot(u, row_terms), right = backend.Dot(v, column_terms);
  backend.Multiply(u, row_terms, row_terms);
  backend.Multiply(v, column_terms, column_terms);
  const double scale = std::sqrt(std::max(backend.Dot(row_terms, row_terms), backend.Dot(column_terms, column_terms)));
  return left == right ? 0 : std::abs(left - right) / std::max(scale, std::numeric_limits<double>::min());
}

template <Backend B>
double WorstAdjointError(B& backend, LinearMap<B>& a, std::uint64_t seed, int ranges) {
  typename B::Vector u(a.rows()), v(a.cols()), confined(a.cols());
  FillRandom(backend, seed, u.view());
  FillRandom(backend, seed + 1, v.view());
  double worst = AdjointError<B>(backend, a, u, v);
  for (int range = 0; range < ranges; ++range) {
    const Index begin = a.cols() * range / ranges, end = a.cols() * (range + 1) / ranges;
    backend.Fill(0, confined);
    backend.Copy(v.view().subspan(begin, end - begin), confined.view().subspan(begin, end - begin));
    worst = std::max(worst, AdjointError<B>(backend, a, u, confined));
  }
  a.Apply(v, u);
  return std::max(worst, AdjointError<B>(backend, a, u, v));
}

template <Backend B>
double DiagonalError(B& backend, Linearization<B>& linearization, Index first, Index stride) {
  return WorstDiagonal(backend, linearization, first, stride).error;
}

template <Backend B>
Deviation WorstDiagonal(B& backend, Linearization<B>& linearization, Index first, Index stride) {
  using S = typename B::Scalar;
  const Index n = linearization.num_parameters();
  typename B::Vector diagonal(n), column;
  linearization.DiagJTJ(diagonal);
  std::vector<S> host(static_cast<std::size_t>(n));
  backend.ToHost(diagonal, {host.data(), n});
  LinearizationAdaptor<B> adaptor(linearization);
  check_internal::Columns<B> columns(backend, adaptor);
  Deviation worst;
  for (Index k = first; k < n; k += stride) {
    columns.Column(k, column);
    const double exact = columns.WeightedProduct(column, column);
    const auto given = static_cast<double>(host[static_cast<std::size_t>(k)]);
    const double error = check_internal::RelativeDifference(given, exact);
    if (error > worst.error) worst = {error, k, k, given, exact};
  }
  return worst;
}

template <Backend B>
double BlockError(B& backend, Linearization<B>& linearization, Index block_stride) {
  return WorstBlock(backend, linearization, block_stride).error;
}

template <Backend B>
Deviation WorstBlock(B& backend, Linearization<B>& linearization, Index block_stride) {
  using S = typename B::Scalar;
  LinearizationAdaptor<B> adaptor(linearization);
  const std::vector<BlockGroup> groups = adaptor.block_groups();
  BlockDiagonal<B> blocks(linearization.num_parameters(), groups);
  adaptor.BlockGram(blocks);
  check_internal::Columns<B> columns(backend, adaptor);
  Deviation worst;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const BlockGroup& group = groups[g];
    std::vector<S> values(static_cast<std::size_t>(group.NumValues()));
    backend.ToHost(blocks.values(static_cast<int>(g)), {values.data(), group.NumValues()});
    std::vector<typename B::Vector> column(static_cast<std::size_t>(group.size));
    std::vector<double> exact(static_cast<std::size_t>(PackedLower(group.size, 0)));
    for (Index block = 0; block < group.count; block += block_stride) {
      for (int row = 0; row < group.size; ++row) {
        const auto r = static_cast<std::size_t>(row);
        columns.Column(group.Parameter(block, row), column[r]);
        for (int col = 0; col <= row; ++col) {
          exact[static_cast<std::size_t>(PackedLower(row, col))] =
              columns.WeightedProduct(column[static_cast<std::size_t>(col)], column[r]);
        }
      }
      const auto exact_at = [&](int row, int col) { return exact[static_cast<std::size_t>(PackedLower(row, col))]; };
      for (int row = 0; row < group.size; ++row) {
        for (int col = 0; col <= row; ++col) {
          const double value =
              static_cast<double>(values[static_cast<std::size_t>(PackedLower(row, col) * group.count + block)]);
          if (exact_at(row, col) == value) continue;
          const double scale = std::sqrt(exact_at(row, row) * exact_at(col, col));
          const double error =
              std::abs(value - exact_at(row, col)) / std::max(scale, std::numeric_limits<double>::min());
          if (error > worst.error) {
            worst = {error, group.Parameter(block, row), group.Parameter(block, col), value, exact_at(row, col)};
          }
        }
      }
    }
  }
  return worst;
}

template <Backend B>
double GradientError(B& backend, Problem<B>& of, typename B::ConstVectorView x, typename B::ConstVectorView v,
                     double h) {
  const ProblemAdaptor<B> problem(of);
  double slope = 0;
  typename B::Vector gradient(problem.num_tangent()), step(problem.num_tangent()), moved(problem.num_parameters());
  for (int batch = 0; batch < problem.num_batches(); ++batch) {
    problem.CheckedLinearize(x, batch)->Gradient(gradient);
    slope += backend.Dot(gradient, v);
  }
  const auto cost_at = [&](double t) {
    backend.Axpby(t, v, 0.0, step);
    problem.Plus(backend, x, step, moved);
    return problem.Cost(moved);
  };
  return check_internal::RelativeDifference(slope, (cost_at(h) - cost_at(-h)) / (2 * h));
}

template <Backend B>
double TangentError(B& backend, Problem<B>& of, typename B::ConstVectorView x, int batch, typename B::ConstVectorView v,
                    double h) {
  const ProblemAdaptor<B> problem(of);
  const auto linearization = problem.CheckedLinearize(x, batch);
  const Index rows = linearization->num_residuals();
  typename B::Vector tangent(rows), difference(rows), step(problem.num_tangent()), moved(problem.num_parameters());
  linearization->ApplyJ(v, tangent);
  for (const double sign : {1.0, -1.0}) {
    backend.Axpby(sign * h, v, 0.0, step);
    problem.Plus(backend, x, step, moved);
    backend.Axpby(sign / (2 * h), problem.CheckedLinearize(moved, batch)->residuals(), 1.0, difference);
  }
  const double norm = std::sqrt(backend.Dot(tangent, tangent));
  backend.Axpby(-1.0, tangent, 1.0, difference);
  return std::sqrt(backend.Dot(difference, difference)) / std::max(norm, std::numeric_limits<double>::min());
}

}  // namespace vesta
