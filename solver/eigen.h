// SPDX-License-Identifier: Apache-2.0
// Dual numbers as scalars of Eigen's matrices. Include this in files whose residual functors use Eigen types of a
// template scalar, such as Eigen::Matrix<T, 3, 1>. Without it, Eigen's decompositions would use wrong tolerances.
#pragma once

#include <Eigen/Core>

#include "kernels/math/derivatives.h"

namespace Eigen {

// Epsilon, the largest number and so on come from std::numeric_limits.
template <class T, int N>
struct NumTraits<vesta::Dual<T, N>> : GenericNumTraits<vesta::Dual<T, N>> {
  // RequireInitialization: dual numbers may be left uninitialised. The costs are numbers of operations on T.
  enum { RequireInitialization = 0, ReadCost = N + 1, AddCost = N + 1, MulCost = 2 * N + 1 };
  static vesta::Dual<T, N> dummy_precision() { return NumTraits<T>::dummy_precision(); }
};

// Sums and products of a matrix of dual numbers with a matrix or scalar of type T.
template <class T, int N, class Operation>
struct ScalarBinaryOpTraits<vesta::Dual<T, N>, T, Operation> {
  using ReturnType = vesta::Dual<T, N>;
};
template <class T, int N, class Operation>
struct ScalarBinaryOpTraits<T, vesta::Dual<T, N>, Operation> {
  using ReturnType = vesta::Dual<T, N>;
};

}  // namespace Eigen
