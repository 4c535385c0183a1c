// SPDX-License-Identifier: Apache-2.0
// The problems of the benchmark small_solves: curve fits and camera poses.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "kernels/core/random.h"

namespace vesta::bench {

// The residual of reading i of a batch functor F, alone. reading: the kData / kReadings numbers of this reading.
template <class F>
struct OneReading {
  static constexpr int kResiduals = F::kResiduals / F::kReadings, kParameters = F::kParameters;
  const double* reading;

  template <class T>
  bool operator()(const T* p, T* r) const {
    F::template Readings<1>(reading, p, r);
    return true;
  }
};

// y = p0 exp(-p1 t) + p2 at 30 times t. Data: t and y of each reading.
struct Curve {
  static constexpr const char* kName = "curve";
  static constexpr int kReadings = 30, kResiduals = 30, kParameters = 3, kData = 60;

  template <int kCount, class V, class T>
  static void Readings(const V* data, const T* p, T* r) {
    using std::exp;
    for (int i = 0; i < kCount; ++i) r[i] = p[0] * exp(-p[1] * data[2 * i]) + p[2] - data[2 * i + 1];
  }
  template <class V, class T>
  bool operator()(const V* data, const T* p, T* r) const {
    Readings<kReadings>(data, p, r);
    return true;
  }
  static std::vector<double> Start() { return {1, 1, 0}; }
  static std::vector<double> Truth(CounterRandom& random) {
    return {2 + random.Uniform(), 0.5 + random.Uniform(), random.Uniform()};
  }
  static void Simulate(CounterRandom& random, const double* truth, double* data) {
    for (int i = 0; i < kReadings; ++i) {
      data[2 * i] = 0.2 * i;
      data[2 * i + 1] = truth[0] * std::exp(-truth[1] * data[2 * i]) + truth[2] + 0.02 * (random.Uniform() - 0.5);
    }
  }
};

// The pose of a camera with unit focal length, from 50 points: a rotation vector and a translation. Data: x, y, z of
// the point and its image coordinates.
struct Pose {
  static constexpr const char* kName = "pose";
  static constexpr int kReadings = 50, kResiduals = 100, kParameters = 6, kData = 250;

  template <int kCount, class V, class T>
  static void Readings(const V* data, const T* p, T* r) {
    using std::cos, std::sin, std::sqrt;
    // Rodrigues' formula. The small number avoids a division by zero.
    const T square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + T(1e-300), angle = sqrt(square);
    const T c = cos(angle), s = sin(angle) / angle, k = (T(1.0) - c) / square;
    const T m[9] = {c + k * p[0] * p[0],        k * p[0] * p[1] - s * p[2], k * p[0] * p[2] + s * p[1],
                    k * p[0] * p[1] + s * p[2], c + k * p[1] * p[1],        k * p[1] * p[2] - s * p[0],
                    k * p[0] * p[2] - s * p[1], k * p[1] * p[2] + s * p[0], c + k * p[2] * p[2]};
    for (int i = 0; i < kCount; ++i, data += 5) {
      const T x = m[0] * data[0] + m[1] * data[1] + m[2] * data[2] + p[3];
      const T y = m[3] * data[0] + m[4] * data[1] + m[5] * data[2] + p[4];
      const T z = m[6] * data[0] + m[7] * data[1] + m[8] * data[2] + p[5];
      const T inverse = T(1.0) / z;
      r[2 * i] = x * inverse - data[3];
      r[2 * i + 1] = y * inverse - data[4];
    }
  }
  template <class V, class T>
  bool operator()(const V* data, const T* p, T* r) const {
    Readings<kReadings>(data, p, r);
    return true;
  }
  static std::vector<double> Start() { return {0, 0, 0, 0, 0, 4.5}; }
  static std::vector<double> Truth(CounterRandom& random) {
    std::vector<double> pose;
    for (int c = 0; c < 3; ++c) pose.push_back(0.6 * (random.Uniform() - 0.5));
    for (int c = 0; c < 2; ++c) pose.push_back(random.Uniform() - 0.5);
    pose.push_back(4 + random.Uniform());
    return pose;
  }
  static void Simulate(CounterRandom& random, const double* truth, double* data) {
    for (int i = 0; i < kReadings; ++i, data += 5) {
      for (int c = 0; c < 3; ++c) data[c] = 2 * random.Uniform() - 1;
      double projection[2];
      data[3] = data[4] = 0;
      Readings<1>(data, truth, projection);
      for (int c = 0; c < 2; ++c) data[3 + c] = projection[c] + 0.002 * (random.Uniform() - 0.5);
    }
  }
};

// `count` problems and their starts.
template <class F>
struct Problems {
  explicit Problems(int count) {
    CounterRandom random(57, 0);
    for (int i = 0; i < count; ++i) {
      const std::vector<double> start = F::Start(), truth = F::Truth(random);
      starts.insert(starts.end(), start.begin(), start.end());
      data.resize(data.size() + F::kData);
      F::Simulate(random, truth.data(), data.data() + data.size() - F::kData);
    }
  }
  const double* data_of(std::size_t i) const { return data.data() + i * F::kData; }

  std::vector<double> data, starts;
};

}  // namespace vesta::bench
