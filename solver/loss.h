// SPDX-License-Identifier: Apache-2.0
// Robust losses rho(s) of the squared norm s of a residual block; the cost is 1/2 sum rho(s). Names, forms and scales
// are Ceres's, so that costs compare digit by digit.
#pragma once

#include <memory>

#include "kernels/core/error.h"

namespace vesta {

class Loss {
 public:
  struct Value {
    double rho = 0;     // rho(s)
    double first = 0;   // rho'(s)
    double second = 0;  // rho''(s)
  };
  virtual ~Loss() = default;
  // s >= 0.
  virtual Value Evaluate(double s) const = 0;
};

// rho = s.
class TrivialLoss final : public Loss {
 public:
  Value Evaluate(double s) const override;
};

// s up to a^2, then 2 a sqrt(s) - a^2. All scales a > 0: where a residual of size a starts to count less.
class HuberLoss final : public Loss {
 public:
  explicit HuberLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double a_;
};

// 2 b (sqrt(1 + s / b) - 1), b = a^2.
class SoftLOneLoss final : public Loss {
 public:
  explicit SoftLOneLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double b_;
};

// b log(1 + s / b), b = a^2.
class CauchyLoss final : public Loss {
 public:
  explicit CauchyLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double b_;
};

// a atan(s / a).
class ArctanLoss final : public Loss {
 public:
  explicit ArctanLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double a_;
};

// b / 3 (1 - (1 - s / b)^3) up to b = a^2, then b / 3: residuals beyond a do not count.
class TukeyLoss final : public Loss {
 public:
  explicit TukeyLoss(double a);
  Value Evaluate(double s) const override;

 private:
  double b_;
};

// b log(1 + exp((s - a) / b)) less its value at s = 0: nothing much up to a, s beyond; b > 0 is how wide the bend is.
class TolerantLoss final : public Loss {
 public:
  TolerantLoss(double a, double b);
  Value Evaluate(double s) const override;

 private:
  double a_, b_, at_zero_;
};

// f(g(s)). Neither may be null.
class ComposedLoss final : public Loss {
 public:
  ComposedLoss(std::shared_ptr<const Loss> f, std::shared_ptr<const Loss> g);
  Value Evaluate(double s) const override;

 private:
  std::shared_ptr<const Loss> f_, g_;
};

// weight * loss(s), or weight * s where there is no loss; weight >= 0.
class ScaledLoss final : public Loss {
 public:
  ScaledLoss(std::shared_ptr<const Loss> loss, double weight);
  Value Evaluate(double s) const override;

 private:
  std::shared_ptr<const Loss> loss_;
  double weight_;
};

// Rewrites a residual block f and its Jacobian J so that plain least squares has the loss's gradient rho' J^T f and the
// curvature J^T (rho' I + 2 max(rho'', 0) f f^T) J (Triggs, McLauchlan, Hartley, Fitzgibbon, Bundle adjustment: a
// modern synthesis, 1999, section 4.3). A negative rho'' is left out, as in Ceres: it would take away from the
// curvature, at worst all of it.
class LossCorrection {
 public:
  // value: the loss at s = |f|^2.
  LossCorrection(const Loss::Value& value, double s);
  // J column-wise or row-wise alike: J(i, c) at jacobian[i * row_stride + c * column_stride]. f is corrected last.
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
  double root_first_;
  double alpha_over_s_ = 0;
  double residual_scale_;
};

}  // namespace vesta
