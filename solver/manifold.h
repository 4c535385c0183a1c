// SPDX-License-Identifier: Apache-2.0
// Manifolds for parameter blocks that have fewer degrees of freedom than numbers, such as unit quaternions.
#pragma once

#include <memory>
#include <vector>

namespace vesta {

// Defines x (+) delta, the point that the step delta leads to from x. x has ambient_size() numbers, delta has
// tangent_size(), and x (+) 0 = x.
class Manifold {
 public:
  virtual ~Manifold() = default;
  virtual int ambient_size() const = 0;
  virtual int tangent_size() const = 0;
  // out = x (+) delta. out may be the same memory as x.
  virtual void Plus(const double* x, const double* delta, double* out) const = 0;
  // jacobian = d(x (+) delta)/d(delta) at delta = 0, row-major: ambient_size() rows, tangent_size() columns.
  virtual void PlusJacobian(const double* x, double* jacobian) const = 0;
};

// Unit quaternions. x (+) delta is the quaternion product [cos |delta|; delta sin |delta| / |delta|] x, a rotation by
// the angle 2 |delta|. Same convention as Ceres's QuaternionManifold (w x y z) and EigenQuaternionManifold (x y z w).
class QuaternionManifold final : public Manifold {
 public:
  enum class Order { kWxyz, kXyzw };
  explicit QuaternionManifold(Order order = Order::kWxyz) : order_(order) {}
  int ambient_size() const override { return 4; }
  int tangent_size() const override { return 3; }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  Order order_;
};

// Vectors of constant length, such as directions. Steps keep the length |x|:
//   x (+) delta = |x| H [delta sin |delta| / |delta|; cos |delta|].
// H is a Householder reflection that maps the last unit vector to x / |x|. |delta| is the angle between x and x (+)
// delta, as in SphereManifold of Ceres 2.2; in Ceres 2.1, |delta| is twice the angle. Source: Hertzberg et al.,
// Integrating generic sensor fusion algorithms with sound state representations through encapsulation of manifolds,
// 2013, appendix B.2. The constructor throws Error for size < 2.
class UnitVectorManifold final : public Manifold {
 public:
  explicit UnitVectorManifold(int size);
  int ambient_size() const override { return size_; }
  int tangent_size() const override { return size_ - 1; }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  int size_;
};

// Lines in R^n, n >= 2, each given by a point o on it and a direction d: x = [o; d], delta = [a; b]. Steps keep the
// length |d|:
//   x (+) delta = [o + H [a; 0]; d (+) b].
// UnitVectorManifold(n) at d defines d (+) b and H. So o moves perpendicularly to the line. LineManifold of Ceres 2.2
// makes the same step from delta; Ceres 2.1 makes it from 2 delta. The constructor throws Error for n < 2.
class LineManifold final : public Manifold {
 public:
  // size: the dimension n of the space.
  explicit LineManifold(int size);
  int ambient_size() const override { return 2 * size_; }
  int tangent_size() const override { return 2 * (size_ - 1); }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  int size_;
};

// Rigid motions, the group SE(3). x = [q; t] is a unit quaternion, in the given order, and a translation. It maps a
// point p to R(q) p + t. With delta = [rho; phi],
//   x (+) delta = x exp(delta),
// so exp(delta) is applied first, then x. exp(delta) rotates by the rotation vector phi (radians) and translates by V
// rho, where V is the left Jacobian of the rotation group at phi. So delta is a twist in the axes of the moved body,
// with the translation first, as in Sophus and manif. A ProductManifold of a quaternion and R^3 instead moves both
// parts independently.
class Se3Manifold final : public Manifold {
 public:
  using Order = QuaternionManifold::Order;
  explicit Se3Manifold(Order order = Order::kWxyz) : order_(order) {}
  int ambient_size() const override { return 7; }
  int tangent_size() const override { return 6; }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  Order order_;
};

// A vector with some constant entries.
class SubsetManifold final : public Manifold {
 public:
  // constant: indices of the constant entries within [0, size). Throws Error if one is out of range or repeated, or if
  // all entries are constant.
  SubsetManifold(int size, const std::vector<int>& constant);
  int ambient_size() const override { return size_; }
  int tangent_size() const override { return static_cast<int>(free_.size()); }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  int size_;
  std::vector<int> free_;
};

// A product of manifolds. x consists of the numbers of the first part, then of the second part, and so on; delta has
// the same order. Example: a pose, with a quaternion and a translation in R^3. No part may be null.
class ProductManifold final : public Manifold {
 public:
  // Throws Error if a part is null.
  explicit ProductManifold(std::vector<std::shared_ptr<const Manifold>> parts);
  int ambient_size() const override { return ambient_; }
  int tangent_size() const override { return tangent_; }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  std::vector<std::shared_ptr<const Manifold>> parts_;
  int ambient_ = 0, tangent_ = 0;
};

// R^n, as a factor of a ProductManifold.
class EuclideanManifold final : public Manifold {
 public:
  explicit EuclideanManifold(int size);
  int ambient_size() const override { return size_; }
  int tangent_size() const override { return size_; }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  int size_;
};

}  // namespace vesta
