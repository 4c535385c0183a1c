// SPDX-License-Identifier: Apache-2.0
// Robust losses rho(s), where s is the squared norm of a residual block. The cost is 1/2 sum rho(s) over the residual
// blocks. Names, formulas and scales are as in Ceres, so costs can be compared directly.
#pragma once

#include <memory>

#include "kernels/core/error.h"

namespace vesta {

// A robust loss: rho(s) and its first two derivatives, for s >= 0.
class Loss {
 public:
  struct Value {
    double rho = 0;     // rho(s)
    double first = 0;   // rho'(s)
    double second = 0;  // rho''(s)
  };
  virtual ~Loss() = default;
  virtual Value Evaluate(double s) const = 0;
};

// rho = s.
class TrivialLoss final : public Loss {
 public:
  Value Evaluate(double s) const override;
};

// rho = s for s <= a^2, else 2 a sqrt(s) - a^2. In most losses here, a > 0 is a norm: residual blocks get less weight
// if their norm is above about a. In ArctanLoss and TolerantLoss, a is a value of s. The constructors throw Error if a
// scale is out of range.
class HuberLoss final : public Loss {
 public:
  explicit HuberLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double a_;
};

// rho = 2 b (sqrt(1 + s / b) - 1), b = a^2.
class SoftLOneLoss final : public Loss {
 public:
  explicit SoftLOneLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double b_;
};

// rho = b log(1 + s / b), b = a^2.
class CauchyLoss final : public Loss {
 public:
  explicit CauchyLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double b_;
};

// rho = a atan(s / a).
class ArctanLoss final : public Loss {
 public:
  explicit ArctanLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double a_;
};

// rho = b / 3 (1 - (1 - s / b)^3) for s <= b = a^2, else b / 3. Residual blocks with a norm above a have no influence.
class TukeyLoss final : public Loss {
 public:
  explicit TukeyLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double b_;
};

// rho = b log(1 + exp((s - a) / b)), minus its value at s = 0: nearly 0 for s < a, nearly s - a for s > a. a >= 0, and
// b > 0 is the width of the transition.
class TolerantLoss final : public Loss {
 public:
  TolerantLoss(double a, double b);
  Value Evaluate(double s) const override;

 private:
  double a_, b_, at_zero_, slope_at_zero_;
};

// rho = f(g(s)). Neither loss may be null.
class ComposedLoss final : public Loss {
 public:
  ComposedLoss(std::shared_ptr<const Loss> f, std::shared_ptr<const Loss> g);
  Value Evaluate(double s) const override;

 private:
  std::shared_ptr<const Loss> f_, g_;
};

// rho = weight * loss(s), or weight * s for a null loss; weight >= 0.
class ScaledLoss final : public Loss {
 public:
  ScaledLoss(std::shared_ptr<const Loss> loss, double weight);
  Value Evaluate(double s) const override;

 private:
  std::shared_ptr<const Loss> loss_;
  double weight_;
};

// Rescales a residual block f and its Jacobian J so that plain least squares has the gradient and curvature of the
// robust loss: rho' J^T f and J^T (rho' I + 2 max(rho'', 0) f f^T) J. Source: Triggs, McLauchlan, Hartley, Fitzgibbon,
// Bundle adjustment: a modern synthesis, 1999, section 4.3. A negative rho'' is ignored, as in Ceres, because it would
// reduce the curvature, possibly to zero.
class LossCorrection {
 public:
  // value: the loss at s = |f|^2.
  LossCorrection(const Loss::Value& value, double s);
  // Overwrites f (`residuals` values) and J (`residuals` rows, `parameters` columns), where J(i, c) is at jacobian[i *
  // row_stride + c * column_stride].
  template <class S>
  void Apply(int residuals, int parameters, S* f, S* jacobian, int row_stride, int column_stride) const {
    for (int c = 0; c < parameters; ++c) {
      S* column = jacobian + c * column_stride;
      S dot = 0;
      for (int i = 0; i < residuals; ++i) dot += f[i] * column[i * row_stride];
      const S along = static_cast<S>(alpha_over_s_) * dot;
      for (int i = 0; i < residuals; ++i) {
        S& entry = column[i * row_stride];
        entry = static_cast<S>(root_first_) * (entry - along * f[i]);
      }
    }
    for (int i = 0; i < residuals; ++i) f[i] *= static_cast<S>(residual_scale_);
  }

 private:
  double root_first_;        // sqrt(rho')
  double alpha_over_s_ = 0;  // alpha / s, with alpha as in the source
  double residual_scale_;    // sqrt(rho') / (1 - alpha)
};

}  // namespace vesta
