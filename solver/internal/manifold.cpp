// SPDX-License-Identifier: Apache-2.0
#include "solver/manifold.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/math/quaternion.h"
#include "kernels/math/rotation_vector.h"
#include "solver/rotation.h"

namespace vesta {

namespace {

// sin(t) / t, and 1 for |t| so small that t^2 is below rounding.
double Sinc(double t) { return std::abs(t) < 1e-8 ? 1.0 : std::sin(t) / t; }

double Norm(const double* v, int n) { return std::sqrt(std::inner_product(v, v + n, v, 0.0)); }

void FillZero(double* jacobian, int rows, int cols) { std::fill_n(jacobian, rows * cols, 0.0); }

// The Householder reflection H = I - 2 v v^T / v^T v that maps |x| e_last to x. v = x - |x| e_last, whose last entry is
// computed without cancellation, as in Golub and Van Loan, Matrix Computations, section 5.1.3. If x is a positive
// multiple of e_last, H = I.
struct Reflection {
  Reflection(const double* x, int size) : v(x, x + size), norm(Norm(x, size)) {
    const double last = v.back(), rest = std::inner_product(v.begin(), v.end() - 1, v.begin(), 0.0);
    v.back() = last > 0 ? -rest / (last + norm) : last - norm;
    const double length = Norm(v.data(), size);
    for (double& entry : v) entry = length > 0 ? entry / length : 0;
  }
  // Entry `row` of H y, given y = y[row] and v^T y.
  double Apply(std::size_t row, double y, double v_dot_y) const { return y - 2 * v_dot_y * v[row]; }
  std::vector<double> v;  // of length 1, or 0
  double norm;            // |x|
};

// out = |x| H [delta sin |delta| / |delta|; cos |delta|] for the reflection H of x, size >= 2 numbers. out may be x.
void TurnVector(const double* x, int size, const double* delta, double* out) {
  const double angle = Norm(delta, size - 1);
  if (angle == 0) {
    std::copy_n(x, size, out);
    return;
  }
  const Reflection h(x, size);
  std::vector<double> y(delta, delta + size - 1);
  for (double& component : y) component *= Sinc(angle);
  y.push_back(std::cos(angle));
  const double v_dot_y = std::inner_product(y.begin(), y.end(), h.v.begin(), 0.0);
  for (std::size_t i = 0; i < y.size(); ++i) out[i] = h.norm * h.Apply(i, y[i], v_dot_y);
}

// Positions of w, x, y, z in memory.
std::array<int, 4> PlacesOf(QuaternionManifold::Order order) {
  if (order == QuaternionManifold::Order::kWxyz) return {0, 1, 2, 3};
  return {3, 0, 1, 2};
}

}  // namespace

void QuaternionManifold::Plus(const double* x, const double* delta, double* out) const {
  const int w = order_ == Order::kWxyz ? 0 : 3, v = order_ == Order::kWxyz ? 1 : 0;
  const double angle = Norm(delta, 3), sinc = Sinc(angle), c = std::cos(angle);
  const double a[3] = {sinc * delta[0], sinc * delta[1], sinc * delta[2]};
  const double qw = x[w], q[3] = {x[v], x[v + 1], x[v + 2]};
  out[w] = c * qw - a[0] * q[0] - a[1] * q[1] - a[2] * q[2];
  out[v] = c * q[0] + a[0] * qw + a[1] * q[2] - a[2] * q[1];
  out[v + 1] = c * q[1] + a[1] * qw + a[2] * q[0] - a[0] * q[2];
  out[v + 2] = c * q[2] + a[2] * qw + a[0] * q[1] - a[1] * q[0];
}

void QuaternionManifold::PlusJacobian(const double* x, double* jacobian) const {
  const int w = order_ == Order::kWxyz ? 0 : 3, v = order_ == Order::kWxyz ? 1 : 0;
  const double qw = x[w], q0 = x[v], q1 = x[v + 1], q2 = x[v + 2];
  const double row_w[3] = {-q0, -q1, -q2};
  const double rows_v[3][3] = {{qw, q2, -q1}, {-q2, qw, q0}, {q1, -q0, qw}};
  std::copy_n(row_w, 3, jacobian + 3 * w);
  for (int i = 0; i < 3; ++i) std::copy_n(rows_v[i], 3, jacobian + 3 * (v + i));
}

UnitVectorManifold::UnitVectorManifold(int size) : size_(size) {
  if (size < 2) Fail(kBadArgument, "a unit vector of {} numbers; it needs 2 or more", size);
}

void UnitVectorManifold::Plus(const double* x, const double* delta, double* out) const {
  TurnVector(x, size_, delta, out);
}

void UnitVectorManifold::PlusJacobian(const double* x, double* jacobian) const {
  const Reflection h(x, size_);
  for (int i = 0; i < size_; ++i) {
    for (int k = 0; k < size_ - 1; ++k) {
      jacobian[i * (size_ - 1) + k] =
          h.norm * h.Apply(static_cast<std::size_t>(i), i == k ? 1.0 : 0.0, h.v[static_cast<std::size_t>(k)]);
    }
  }
}

LineManifold::LineManifold(int size) : size_(size) {
  if (size < 2) Fail(kBadArgument, "a line in a space of {} dimensions; it needs 2 or more", size);
}

void LineManifold::Plus(const double* x, const double* delta, double* out) const {
  const int n = size_ - 1;
  const Reflection h(x + size_, size_);
  const double v_dot_a = std::inner_product(delta, delta + n, h.v.begin(), 0.0);
  for (int i = 0; i < size_; ++i) out[i] = x[i] + h.Apply(static_cast<std::size_t>(i), i < n ? delta[i] : 0.0, v_dot_a);
  TurnVector(x + size_, size_, delta + n, out + size_);
}

void LineManifold::PlusJacobian(const double* x, double* jacobian) const {
  const int n = size_ - 1;
  FillZero(jacobian, 2 * size_, 2 * n);
  const Reflection h(x + size_, size_);
  for (int i = 0; i < size_; ++i) {
    for (int k = 0; k < n; ++k) {
      const double entry = h.Apply(static_cast<std::size_t>(i), i == k ? 1.0 : 0.0, h.v[static_cast<std::size_t>(k)]);
      jacobian[i * 2 * n + k] = entry;
      jacobian[(size_ + i) * 2 * n + n + k] = h.norm * entry;
    }
  }
}

void Se3Manifold::Plus(const double* x, const double* delta, double* out) const {
  const auto places = PlacesOf(order_);
  double q[4], turn[4], turned[4], unit[4];
  for (std::size_t i = 0; i < 4; ++i) q[i] = x[places[i]];
  const double *rho = delta, *phi = delta + 3;
  // V rho = rho + B phi x rho + C phi x (phi x rho).
  double c[3], once[3], twice[3], moved[3];
  AngleCoefficients(DotProduct(phi, phi), c);
  CrossProduct(phi, rho, once);
  CrossProduct(phi, once, twice);
  for (int i = 0; i < 3; ++i) moved[i] = rho[i] + c[1] * once[i] + c[2] * twice[i];
  NormalizeQuaternion(q, unit);
  UnitQuaternionRotatePoint(unit, moved, moved);
  AngleAxisToQuaternion(phi, turn);
  QuaternionProduct(q, turn, turned);
  for (int i = 0; i < 3; ++i) out[4 + i] = x[4 + i] + moved[i];
  for (std::size_t i = 0; i < 4; ++i) out[places[i]] = turned[i];
}

void Se3Manifold::PlusJacobian(const double* x, double* jacobian) const {
  const auto places = PlacesOf(order_);
  FillZero(jacobian, 7, 6);
  double q[4], rotation[9];
  for (std::size_t i = 0; i < 4; ++i) q[i] = x[places[i]];
  RotationFromQuaternion(q, rotation);
  for (int i = 0; i < 3; ++i) std::copy_n(rotation + 3 * i, 3, jacobian + 6 * (4 + i));
  for (int k = 0; k < 3; ++k) {
    double half[4] = {0, 0, 0, 0}, column[4];
    half[1 + k] = 0.5;
    QuaternionProduct(q, half, column);
    for (std::size_t i = 0; i < 4; ++i) jacobian[6 * places[i] + 3 + k] = column[i];
  }
}

SubsetManifold::SubsetManifold(int size, const std::vector<int>& constant) : size_(size) {
  for (const int k : constant) {
    if (k < 0 || k >= size) Fail(kBadArgument, "constant entry {} is out of range for a block of {} numbers", k, size);
  }
  for (int k = 0; k < size; ++k) {
    if (std::find(constant.begin(), constant.end(), k) == constant.end()) free_.push_back(k);
  }
  if (size - tangent_size() != static_cast<int>(constant.size()))
    Fail(kBadArgument, "a constant entry is listed twice");
  if (free_.empty()) Fail(kBadArgument, "all {} entries are constant; make the block constant instead", size);
}

void SubsetManifold::Plus(const double* x, const double* delta, double* out) const {
  std::copy_n(x, size_, out);
  for (std::size_t k = 0; k < free_.size(); ++k) out[free_[k]] += delta[k];
}

void SubsetManifold::PlusJacobian(const double*, double* jacobian) const {
  FillZero(jacobian, size_, tangent_size());
  for (int k = 0; k < tangent_size(); ++k) jacobian[free_[static_cast<std::size_t>(k)] * tangent_size() + k] = 1;
}

ProductManifold::ProductManifold(std::vector<std::shared_ptr<const Manifold>> parts) : parts_(std::move(parts)) {
  for (const auto& part : parts_) {
    if (!part) Fail(kBadArgument, "part {} of a product manifold is null", &part - parts_.data());
    ambient_ += part->ambient_size();
    tangent_ += part->tangent_size();
  }
}

void ProductManifold::Plus(const double* x, const double* delta, double* out) const {
  for (const auto& part : parts_) {
    part->Plus(x, delta, out);
    x += part->ambient_size();
    out += part->ambient_size();
    delta += part->tangent_size();
  }
}

void ProductManifold::PlusJacobian(const double* x, double* jacobian) const {
  FillZero(jacobian, ambient_, tangent_);
  std::vector<double> own;
  int row = 0, col = 0;
  for (const auto& part : parts_) {
    const int rows = part->ambient_size(), cols = part->tangent_size();
    own.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols));
    part->PlusJacobian(x + row, own.data());
    for (int i = 0; i < rows; ++i) std::copy_n(own.data() + i * cols, cols, jacobian + (row + i) * tangent_ + col);
    row += rows;
    col += cols;
  }
}

EuclideanManifold::EuclideanManifold(int size) : size_(size) {
  if (size < 1) Fail(kBadArgument, "a Euclidean space of {} dimensions", size);
}

void EuclideanManifold::Plus(const double* x, const double* delta, double* out) const {
  std::transform(x, x + size_, delta, out, [](double a, double b) { return a + b; });
}

void EuclideanManifold::PlusJacobian(const double*, double* jacobian) const {
  FillZero(jacobian, size_, size_);
  for (int k = 0; k < size_; ++k) jacobian[k * (size_ + 1)] = 1;
}

}  // namespace vesta
