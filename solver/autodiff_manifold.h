// SPDX-License-Identifier: Apache-2.0
// Manifolds whose step is a functor, differentiated automatically.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "kernels/math/dual.h"
#include "solver/internal/functor_call.h"
#include "solver/manifold.h"

namespace vesta {

// Makes a manifold from a functor, as ceres::AutoDiffManifold. F has a member function
//   template <class T> bool Plus(const T* x, const T* delta, T* x_plus_delta) const;
// which is called with T = double and Dual<double>. It may return void. If it returns false, x (+) delta is undefined:
// all numbers become NaN, and the step is rejected. A member function Minus, which Ceres needs, is not used.
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
    std::array<Dual<double>, kAmbient> point, result;
    std::array<Dual<double>, kTangent> delta;
    for (std::size_t i = 0; i < point.size(); ++i) point[i] = Dual<double>(x[i]);
    delta.fill(Dual<double>(0.0));
    for (std::size_t k = 0; k < delta.size(); ++k) {
      delta[k].v = 1;
      Call(point.data(), delta.data(), result.data());
      delta[k].v = 0;
      for (std::size_t i = 0; i < result.size(); ++i) jacobian[i * delta.size() + k] = result[i].v;
    }
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
