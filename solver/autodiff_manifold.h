// SPDX-License-Identifier: Apache-2.0
// Manifolds whose step is a functor. Its derivatives are computed automatically.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "solver/internal/derivative_passes.h"
#include "solver/manifold.h"

namespace vesta {

// Makes a manifold from a functor, as ceres::AutoDiffManifold. F has a member function
//   template <class T> bool Plus(const T* x, const T* delta, T* x_plus_delta) const;
// which is called with T = double and Dual<double, N>. It may return void. If it returns false, x (+) delta is
// undefined: all numbers become NaN, and the step is rejected. A member function Minus, which Ceres needs, is not used.
template <class F, int kAmbient, int kTangent>
class AutoDiffManifold final : public Manifold {
 public:
  static_assert(kAmbient > 0 && kTangent > 0 && kTangent <= kAmbient);
  explicit AutoDiffManifold(F functor = F()) : functor_(std::move(functor)) {}
  int ambient_size() const override { return kAmbient; }
  int tangent_size() const override { return kTangent; }
  void Plus(const double* x, const double* delta, double* out) const override {
    std::array<double, kAmbient> result;
    Call(x, delta, result.data());
    std::copy(result.begin(), result.end(), out);
  }
  void PlusJacobian(const double* x, double* jacobian) const override {
    using D = Dual<double, DerivativesPerPass<double>(kTangent)>;
    std::array<D, kAmbient> point, result;
    std::array<D, kTangent> delta;
    for (std::size_t i = 0; i < point.size(); ++i) point[i] = D(x[i]);
    delta.fill(D(0.0));
    DifferentiateInPasses(
        kTangent, [&](int k) -> D& { return delta[static_cast<std::size_t>(k)]; },
        [&] {
          Call(point.data(), delta.data(), result.data());
          return true;
        },
        [&](int first, int count) {
          for (int i = 0; i < kAmbient; ++i) {
            for (int k = 0; k < count; ++k) {
              jacobian[i * kTangent + first + k] = DerivativeOf(result[static_cast<std::size_t>(i)], k);
            }
          }
        });
  }

 private:
  template <class T>
  void Call(const T* x, const T* delta, T* result) const {
    MarkUnwritten(kAmbient, result);
    const auto plus = [this](const T* from, const T* step, T* to) { return functor_.Plus(from, step, to); };
    if (!InvokeFunctor(plus, x, delta, result)) MarkUnwritten(kAmbient, result);
  }
  F functor_;
};

}  // namespace vesta
