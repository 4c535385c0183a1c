// SPDX-License-Identifier: Apache-2.0
// Manifolds: parameters that live in fewer dimensions than the numbers that hold them.
#pragma once

#include <memory>
#include <vector>

namespace vesta {

// x (+) delta, for x of ambient_size() numbers and delta of tangent_size(). Plus(x, 0) = x.
class Manifold {
 public:
  virtual ~Manifold() = default;
  virtual int ambient_size() const = 0;
  virtual int tangent_size() const = 0;
  // out = x (+) delta. out may be x.
  virtual void Plus(const double* x, const double* delta, double* out) const = 0;
  // d(x (+) delta)/d(delta) at delta = 0: ambient_size() rows of tangent_size(), row after row.
  virtual void PlusJacobian(const double* x, double* jacobian) const = 0;
};

// Unit quaternions: x (+) delta = [cos |delta|; delta sin |delta| / |delta|] x, a turn by twice |delta|: the convention
// of Ceres's QuaternionManifold (w x y z) and EigenQuaternionManifold (x y z w).
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

// Vectors that keep their length (directions), size >= 2: x (+) delta = |x| H [delta sin |delta| / |delta|; cos
// |delta|], H orthogonal with H e_last = x / |x|, from a Householder reflection (Hertzberg et al., Integrating generic
// sensor fusion algorithms with sound state representations through encapsulation of manifolds, 2013, appendix B.2).
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

// A vector some of whose entries stay as they are.
class SubsetManifold final : public Manifold {
 public:
  // constant: positions within [0, size), no repeats, not all of them.
  SubsetManifold(int size, const std::vector<int>& constant);
  int ambient_size() const override { return size_; }
  int tangent_size() const override { return static_cast<int>(free_.size()); }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  int size_;
  std::vector<int> free_;
};

// Several manifolds side by side, as a pose of a quaternion and a Euclidean translation.
class ProductManifold final : public Manifold {
 public:
  explicit ProductManifold(std::vector<std::shared_ptr<const Manifold>> parts);
  int ambient_size() const override { return ambient_; }
  int tangent_size() const override { return tangent_; }
  void Plus(const double* x, const double* delta, double* out) const override;
  void PlusJacobian(const double* x, double* jacobian) const override;

 private:
  std::vector<std::shared_ptr<const Manifold>> parts_;
  int ambient_ = 0, tangent_ = 0;
};

// R^n: for products.
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
