// SPDX-License-Identifier: Apache-2.0
// The normal equations of a least-squares problem with few parameters, for one problem or for one problem per lane.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include "kernels/core/packed.h"
#include "solver/internal/small/small_rows.h"

namespace vesta::small_internal {

// Costs of problems of type float are sums of type double.
template <class V>
using CostOf = std::conditional_t<std::is_same_v<V, float>, double, V>;

// One point, and the quadratic model of the cost there.
template <class V, int N>
struct SmallSystem {
  V x[N];
  V h[PackedSize(N)];  // J^T J, a packed lower triangle
  V g[N];              // J^T r
  CostOf<V> cost;      // 1/2 |r|^2
};

// A dual number stores its N derivatives in SIMD vectors of this type.
template <class V, int N>
struct PartsOfRow {
  using Vector = typename DerivativeVector<V>::Type;
  static constexpr int kWidth = DerivativeVector<V>::kWidth;
};
template <class V>
struct PartsOfRow<V, 1> {
  using Vector = V;
  static constexpr int kWidth = 1;
};

// Sums over the rows, in SIMD registers. The vector `part` of a row's derivatives, times the row's derivative `column`,
// is added to column `column` of H; column N is the gradient. A few sums at a time fit into registers.
template <class Rows>
class RowSums {
  static constexpr int N = Rows::kParameters;
  using V = typename Rows::V;
  using Vector = typename PartsOfRow<V, N>::Vector;
  static constexpr int kWidth = PartsOfRow<V, N>::kWidth, kParts = (N + kWidth - 1) / kWidth;
  struct Term {
    int part, column;
  };
  // Column c of H needs only the vectors with entries in rows >= c, because H is symmetric.
  static constexpr int kTerms = [] {
    int count = kParts;
    for (int column = 0; column < N; ++column) count += kParts - column / kWidth;
    return count;
  }();
  static constexpr std::array<Term, kTerms> kTermsOf = [] {
    std::array<Term, kTerms> terms{};
    std::size_t count = 0;
    for (int column = 0; column <= N; ++column) {
      for (int part = column == N ? 0 : column / kWidth; part < kParts; ++part) terms[count++] = {part, column};
    }
    return terms;
  }();
#if defined(__AVX512F__)
  static constexpr int kMost = 28;
#else
  static constexpr int kMost = 12;
#endif

 public:
  static void Add(const Rows& rows, SmallSystem<V, N>& system) { Blocks<0>(rows, system); }

 private:
  template <int kFirst>
  static void Blocks(const Rows& rows, SmallSystem<V, N>& system) {
    constexpr int kCount = std::min(kMost, kTerms - kFirst);
    Block<kFirst>(rows, system, std::make_index_sequence<kCount>());
    if constexpr (kFirst + kCount < kTerms) Blocks<kFirst + kCount>(rows, system);
  }
  template <int kFirst, std::size_t... i>
  static void Block(const Rows& rows, SmallSystem<V, N>& system, std::index_sequence<i...>) {
    Vector sums[] = {(static_cast<void>(i), V(0) - Vector())...};
    for (int k = 0; k < rows.rows(); ++k) {
      const auto& row = rows.dual(k);
      ((sums[i] += PartOf(row, kTermsOf[kFirst + i].part) * FactorOf(row, kTermsOf[kFirst + i].column)), ...);
    }
    (Store<kFirst + static_cast<int>(i)>(sums[i], system), ...);
  }
  template <class D>
  static const Vector& PartOf(const D& row, int part) {
    if constexpr (N == 1) {
      return row.v;
    } else {
      return row.v.parts[part];
    }
  }
  template <class D>
  static const V& FactorOf(const D& row, int column) {
    return column == N ? row.a : DerivativeOf(row, column);
  }
  template <int kTerm>
  static void Store(const Vector& sum, SmallSystem<V, N>& system) {
    constexpr Term term = kTermsOf[kTerm];
    const V* values = reinterpret_cast<const V*>(&sum);
    for (int i = 0; i < kWidth; ++i) {
      const int row = term.part * kWidth + i;
      if (row >= N) break;
      if (term.column == N) {
        system.g[row] = values[i];
      } else if (row >= term.column) {
        system.h[PackedLower(row, term.column)] = values[i];
      }
    }
  }
};

// Computes H, g and the cost from residuals and derivatives.
template <class Rows>
void Accumulate(const Rows& rows, SmallSystem<typename Rows::V, Rows::kParameters>& system) {
  constexpr int N = Rows::kParameters;
  using V = typename Rows::V;
  CostOf<V> sum = 0;
  for (int k = 0; k < rows.rows(); ++k) sum += CostOf<V>(rows.value(k)) * CostOf<V>(rows.value(k));
  system.cost = CostOf<V>(0.5) * sum;
  if constexpr (Rows::kOnePass) {
    RowSums<Rows>::Add(rows, system);
  } else {
    for (V& value : system.h) value = V(0);
    for (V& value : system.g) value = V(0);
    for (int k = 0; k < rows.rows(); ++k) {
      for (int r = 0; r < N; ++r) {
        const V factor = rows.derivative(k, r);
        system.g[r] += factor * rows.value(k);
        for (int c = 0; c <= r; ++c) system.h[PackedLower(r, c)] += factor * rows.derivative(k, c);
      }
    }
  }
}

// Solves (H + diag(damping)) step = -g by the factorisation L D L^T. Returns, per lane, whether the step is accurate to
// about six digits or more. The smallest pivot, relative to its diagonal entry, bounds the relative error.
template <class V, int N>
MaskOf<V> SolveNormalEquations(const SmallSystem<V, N>& system, const V* damping, V* step) {
  const V kSmallestPivot(std::is_same_v<V, float> ? 1e-3 : 1e-10);
  V l[PackedSize(N)], inverse[N];
  auto accurate = MaskOf<V>(true);
  for (int r = 0; r < N; ++r) {
    const V diagonal = system.h[PackedLower(r, r)] + damping[r];
    V pivot = diagonal, value = -system.g[r];
    for (int c = 0; c < r; ++c) {
      V u = system.h[PackedLower(r, c)];
      for (int k = 0; k < c; ++k) u -= l[PackedLower(r, k)] * l[PackedLower(c, k)];
      l[PackedLower(r, c)] = u;  // L D
    }
    for (int c = 0; c < r; ++c) {
      const V u = l[PackedLower(r, c)];
      const V scaled = u * inverse[c];
      pivot -= u * scaled;
      value -= scaled * step[c];
      l[PackedLower(r, c)] = scaled;
    }
    accurate = accurate && pivot > kSmallestPivot * diagonal;
    inverse[r] = V(1) / pivot;
    step[r] = value;
  }
  for (int r = N - 1; r >= 0; --r) {
    V value = step[r] * inverse[r];
    for (int k = r + 1; k < N; ++k) value -= l[PackedLower(k, r)] * step[k];
    step[r] = value;
  }
  return accurate;
}

// The same step for one lane, by Givens rotations of J itself, which lose fewer digits if J is ill-conditioned (Golub
// and Van Loan, Matrix Computations, section 5.2.5). The rows are rotated one by one into the triangle R.
template <class Rows, class S = NumberOf<typename Rows::V>>
void SolveByRotations(const Rows& rows, int lane, const S* damping, S* step) {
  constexpr int N = Rows::kParameters;
  S r[N][N] = {}, c[N] = {}, row[N];
  for (int i = 0; i < N; ++i) r[i][i] = std::sqrt(damping[i]);
  for (int k = 0; k < rows.rows(); ++k) {
    for (int i = 0; i < N; ++i) row[i] = Entry(rows.derivative(k, i), lane);
    S rhs = -Entry(rows.value(k), lane);
    for (int i = 0; i < N; ++i) {
      if (row[i] == 0) continue;
      const S length = std::hypot(r[i][i], row[i]), cosine = r[i][i] / length, sine = row[i] / length;
      for (int j = i; j < N; ++j) {
        const S above = r[i][j];
        r[i][j] = cosine * above + sine * row[j];
        row[j] = cosine * row[j] - sine * above;
      }
      const S above = c[i];
      c[i] = cosine * above + sine * rhs;
      rhs = cosine * rhs - sine * above;
    }
  }
  for (int i = N - 1; i >= 0; --i) {
    S value = c[i];
    for (int j = i + 1; j < N; ++j) value -= r[i][j] * step[j];
    step[i] = value / r[i][i];
  }
}

}  // namespace vesta::small_internal
