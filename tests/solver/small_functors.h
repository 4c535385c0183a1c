// SPDX-License-Identifier: Apache-2.0
// Small problems for the tests of SmallSolver and SolveEach.
#pragma once

#include <cmath>
#include <vector>

#include "kernels/core/random.h"
#include "solver/small_solver.h"

namespace vesta {

// y = p0 exp(-p1 t) + p2 at t = 0, 0.2, ... The data are the y.
struct DecayBatch {
  static constexpr int kReadings = 15, kResiduals = kReadings, kParameters = 3, kData = kReadings;
  template <class V, class T>
  void operator()(const V* y, const T* p, T* r) const {
    using std::exp;
    for (int i = 0; i < kReadings; ++i) r[i] = p[0] * exp(-p[1] * V(0.2 * i)) + p[2] - y[i];
  }
  // Readings with errors of up to `error`, for the parameters p.
  static std::vector<double> Readings(const std::vector<double>& p, double error, std::uint64_t seed) {
    CounterRandom random(seed, 0);
    std::vector<double> y;
    y.reserve(kReadings);
    for (int i = 0; i < kReadings; ++i) {
      y.push_back(p[0] * std::exp(-p[1] * 0.2 * i) + p[2] + error * (2 * random.Uniform() - 1));
    }
    return y;
  }
};

// Rosenbrock's function; minimum 0 at (1, 1).
struct Rosenbrock {
  static constexpr int kResiduals = 2, kParameters = 2;
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = T(10.0) * (p[1] - p[0] * p[0]);
    r[1] = T(1.0) - p[0];
  }
};

// Powell's singular function; minimum 0 at 0, where J has rank 2.
struct Powell {
  static constexpr int kResiduals = 4, kParameters = 4;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::sqrt;
    r[0] = p[0] + T(10.0) * p[1];
    r[1] = T(std::sqrt(5.0)) * (p[2] - p[3]);
    r[2] = (p[1] - T(2.0) * p[2]) * (p[1] - T(2.0) * p[2]);
    r[3] = T(std::sqrt(10.0)) * (p[0] - p[3]) * (p[0] - p[3]);
  }
};

// A polynomial of degree 7 in monomials on [0, 1]: the condition number of J is about 1e6. Minimum 0 at (1, ..., 1).
struct Monomials {
  static constexpr int kResiduals = 20, kParameters = 8;
  template <class T>
  void operator()(const T* p, T* r) const {
    for (int i = 0; i < kResiduals; ++i) {
      T sum(0.0);
      double power = 1;
      for (int k = 0; k < kParameters; ++k, power *= i / 19.0) sum = sum + (p[k] - T(1.0)) * T(power);
      r[i] = sum;
    }
  }
};

// p[1] has no influence.
struct UnusedParameter {
  static constexpr int kResiduals = 2, kParameters = 2;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp;
    r[0] = exp(p[0]) - T(2.0);
    r[1] = T(0.5) * p[0];
  }
};

}  // namespace vesta
