// SPDX-License-Identifier: Apache-2.0
// The loss by direct sums over two-dimensional windows, for any scalar type.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/image/image_shape.h"

namespace vesta::reference {

using WindowWeights = std::array<std::array<double, 11>, 11>;

inline WindowWeights Window() {
  WindowWeights window{};
  double sum = 0.0;
  for (int i = 0; i < 11; ++i) {
    for (int j = 0; j < 11; ++j)
      sum += window[i][j] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
  }
  for (auto& row : window) {
    for (double& weight : row) weight /= sum;
  }
  return window;
}

// Weighted sum of f(neighbour) over the window around `centre`, within the image.
template <class T, class F>
T Blur(const ImageShape& shape, Index centre, const F& f, bool squared_weights = false) {
  static const WindowWeights kWindow = Window();
  const Index row = centre / shape.width, plane = row / shape.height;
  const Index line = row % shape.height, column = centre % shape.width;
  T sum(0.0);
  for (Index i = std::max<Index>(0, line - 5); i < std::min<Index>(shape.height, line + 6); ++i) {
    for (Index j = std::max<Index>(0, column - 5); j < std::min<Index>(shape.width, column + 6); ++j) {
      const double weight = kWindow[i - line + 5][j - column + 5];
      sum += T(squared_weights ? weight * weight : weight) * f((plane * shape.height + i) * shape.width + j);
    }
  }
  return sum;
}

template <class T>
struct WindowTerms {
  T mean_x, mean_y, variance_x, variance_y, covariance;

  T D1() const { return mean_x * mean_x + mean_y * mean_y + T(1e-4); }
  T D2() const { return variance_x + variance_y + T(9e-4); }
  T Luminance() const { return (T(2.0) * mean_x * mean_y + T(1e-4)) / D1(); }
  T Ssim() const { return Luminance() * (T(2.0) * covariance + T(9e-4)) / D2(); }
};

template <class T>
WindowTerms<T> TermsAt(const std::vector<T>& x, const std::vector<T>& y, const ImageShape& shape, Index i) {
  const auto blur = [&](const auto& f) { return Blur<T>(shape, i, f); };
  WindowTerms<T> w;
  w.mean_x = blur([&](Index k) { return x[k]; });
  w.mean_y = blur([&](Index k) { return y[k]; });
  w.variance_x = blur([&](Index k) { return x[k] * x[k]; }) - w.mean_x * w.mean_x;
  w.variance_y = blur([&](Index k) { return y[k] * y[k]; }) - w.mean_y * w.mean_y;
  w.covariance = blur([&](Index k) { return x[k] * y[k]; }) - w.mean_x * w.mean_y;
  return w;
}

// 1 - SSIM of each pixel and channel.
template <class T>
std::vector<T> Dissimilarity(const std::vector<T>& x, const std::vector<T>& y, const ImageShape& shape) {
  std::vector<T> result;
  for (Index i = 0; i < shape.NumValues(); ++i) result.push_back(T(1.0) - TermsAt(x, y, shape, i).Ssim());
  return result;
}

// |e|, or the parabola below the floor.
template <class T>
T Floored(const T& e, double floor) {
  const T absolute = e < T(0.0) ? -e : e;
  return absolute < T(floor) ? (e * e / T(floor) + T(floor)) / T(2.0) : absolute;
}

// Random values in lo..hi.
template <class S>
HostBuffer<S> RandomImage(const ImageShape& shape, unsigned seed, double lo = 0.0, double hi = 1.0) {
  std::mt19937 generator(seed);
  HostBuffer<S> image(shape.NumValues());
  for (S& value : image) value = static_cast<S>(lo + (hi - lo) * (static_cast<double>(generator()) / 4294967296.0));
  return image;
}

// In 0..1, up to `amplitude` from `image`.
template <class S>
HostBuffer<S> Near(const HostBuffer<S>& image, const ImageShape& shape, unsigned seed, double amplitude) {
  HostBuffer<S> other = RandomImage<S>(shape, seed, -amplitude, amplitude);
  for (Index i = 0; i < other.size(); ++i) other[i] = std::min(S(1), std::max(S(0), image[i] + other[i]));
  return other;
}

template <class T, class S>
std::vector<T> ToVector(const HostBuffer<S>& buffer) {
  std::vector<T> result;
  for (const S value : buffer) result.push_back(T(static_cast<double>(value)));
  return result;
}

template <class S>
double Dot(const HostBuffer<S>& a, const HostBuffer<S>& b) {
  double sum = 0.0;
  for (Index i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
  return sum;
}

// Scale for adjointness errors: the root of the sum of the squared terms of a dot product.
template <class S>
double DotScale(const HostBuffer<S>& a, const HostBuffer<S>& b) {
  double sum = 0.0;
  for (Index i = 0; i < a.size(); ++i) sum += std::pow(static_cast<double>(a[i]) * static_cast<double>(b[i]), 2);
  return std::sqrt(sum);
}

template <class S>
double MaxAbs(const HostBuffer<S>& a) {
  double result = 0.0;
  for (const S value : a) result = std::max(result, std::abs(static_cast<double>(value)));
  return result;
}

// Smaller than the window in one or both directions, odd, larger than a band of rows and several vectors, and multiples
// of every vector width.
inline std::vector<ImageShape> Shapes() {
  return {{.width = 1, .height = 1},   {.width = 3, .height = 7},   {.width = 12, .height = 9},
          {.width = 17, .height = 31}, {.width = 32, .height = 13}, {.width = 69, .height = 101}};
}

}  // namespace vesta::reference
