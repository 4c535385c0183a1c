// SPDX-License-Identifier: Apache-2.0
// The models of the NIST problems: Model::Predict(b, x), for any scalar type of b.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "bench/collections/nist_data.h"

namespace vesta::nist {

// b1 (1 - exp(-b2 x))
struct Saturation {
  static constexpr int kParameters = 2;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    return b[0] * (T(1) - exp(-b[1] * T(x[0])));
  }
};

// b1 (1 - (1 + b2 x / 2)^-2)
struct Misra1bModel {
  static constexpr int kParameters = 2;
  template <class T>
  static T Predict(const T* b, const double* x) {
    const T base = T(1) + b[1] * T(0.5 * x[0]);
    return b[0] * (T(1) - T(1) / (base * base));
  }
};

// b1 (1 - (1 + 2 b2 x)^-1/2)
struct Misra1cModel {
  static constexpr int kParameters = 2;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::sqrt;
    return b[0] * (T(1) - T(1) / sqrt(T(1) + b[1] * T(2 * x[0])));
  }
};

// b1 b2 x / (1 + b2 x)
struct Misra1dModel {
  static constexpr int kParameters = 2;
  template <class T>
  static T Predict(const T* b, const double* x) {
    const T product = b[1] * T(x[0]);
    return b[0] * product / (T(1) + product);
  }
};

// exp(-b1 x) / (b2 + b3 x)
struct Chwirut {
  static constexpr int kParameters = 3;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    return exp(-b[0] * T(x[0])) / (b[1] + b[2] * T(x[0]));
  }
};

// b1 x^b2
struct Power {
  static constexpr int kParameters = 2;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::pow;
    return b[0] * pow(T(x[0]), b[1]);
  }
};

// b1 (b2 + x)^(-1 / b3)
struct ShiftedPower {
  static constexpr int kParameters = 3;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::pow;
    return b[0] * pow(b[1] + T(x[0]), T(-1) / b[2]);
  }
};

// b1 + three sinusoids: one with a period of 12 months, two with the periods b4 and b7
struct Cycles {
  static constexpr int kParameters = 9;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::cos, std::sin;
    const double turns = 2 * std::numbers::pi * x[0];
    const T year = T(turns / 12), second = T(turns) / b[3], third = T(turns) / b[6];
    return b[0] + b[1] * cos(year) + b[2] * sin(year) + b[4] * cos(second) + b[5] * sin(second) + b[7] * cos(third) +
           b[8] * sin(third);
  }
};

// (b1 / b2) exp(-((x - b3) / b2)^2 / 2)
struct Bell {
  static constexpr int kParameters = 3;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    const T offset = (T(x[0]) - b[2]) / b[1];
    return b[0] / b[1] * exp(T(-0.5) * offset * offset);
  }
};

// b1 exp(-b2 x) + b3 exp(-((x - b4) / b5)^2) + b6 exp(-((x - b7) / b8)^2)
struct TwoPeaks {
  static constexpr int kParameters = 8;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    const T first = (T(x[0]) - b[3]) / b[4], second = (T(x[0]) - b[6]) / b[7];
    return b[0] * exp(-b[1] * T(x[0])) + b[2] * exp(-first * first) + b[5] * exp(-second * second);
  }
};

// (b1 + b2 x + b3 x^2 + b4 x^3) / (1 + b5 x + b6 x^2 + b7 x^3)
struct CubicByCubic {
  static constexpr int kParameters = 7;
  template <class T>
  static T Predict(const T* b, const double* px) {
    const T x(px[0]);
    return (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (T(1) + x * (b[4] + x * (b[5] + x * b[6])));
  }
};

// (b1 + b2 x + b3 x^2) / (1 + b4 x + b5 x^2)
struct QuadraticByQuadratic {
  static constexpr int kParameters = 5;
  template <class T>
  static T Predict(const T* b, const double* px) {
    const T x(px[0]);
    return (b[0] + x * (b[1] + x * b[2])) / (T(1) + x * (b[3] + x * b[4]));
  }
};

// b1 exp(-b2 x) + b3 exp(-b4 x) + b5 exp(-b6 x)
struct ThreeDecays {
  static constexpr int kParameters = 6;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    const T t(x[0]);
    return b[0] * exp(-b[1] * t) + b[2] * exp(-b[3] * t) + b[4] * exp(-b[5] * t);
  }
};

// b1 (x^2 + b2 x) / (x^2 + b3 x + b4)
struct Mgh09Model {
  static constexpr int kParameters = 4;
  template <class T>
  static T Predict(const T* b, const double* px) {
    const T x(px[0]);
    return b[0] * x * (x + b[1]) / (x * (x + b[2]) + b[3]);
  }
};

// b1 exp(b2 / (x + b3))
struct Mgh10Model {
  static constexpr int kParameters = 3;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    return b[0] * exp(b[1] / (T(x[0]) + b[2]));
  }
};

// b1 + b2 exp(-b4 x) + b3 exp(-b5 x)
struct TwoDecays {
  static constexpr int kParameters = 5;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    const T t(x[0]);
    return b[0] + b[1] * exp(-b[3] * t) + b[2] * exp(-b[4] * t);
  }
};

// b1 - b2 x1 exp(-b3 x2), fitted to the logarithm of y
struct NelsonModel {
  static constexpr int kParameters = 3;
  static double Response(double y) { return std::log(y); }
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    return b[0] - b[1] * T(x[0]) * exp(-b[2] * T(x[1]));
  }
};

// b1 / (1 + exp(b2 - b3 x))
struct Logistic {
  static constexpr int kParameters = 3;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp;
    return b[0] / (T(1) + exp(b[1] - b[2] * T(x[0])));
  }
};

// b1 / (1 + exp(b2 - b3 x))^(1 / b4)
struct GeneralizedLogistic {
  static constexpr int kParameters = 4;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::exp, std::pow;
    return b[0] / pow(T(1) + exp(b[1] - b[2] * T(x[0])), T(1) / b[3]);
  }
};

// b1 - b2 x - atan(b3 / (x - b4)) / pi
struct RoszmanModel {
  static constexpr int kParameters = 4;
  template <class T>
  static T Predict(const T* b, const double* x) {
    using std::atan;
    return b[0] - b[1] * T(x[0]) - atan(b[2] / (T(x[0]) - b[3])) * T(std::numbers::inv_pi);
  }
};

// Prediction minus response of one observation, for ResidualBlocks and, through ToCeres, for Ceres.
template <class Model>
struct Residual {
  static constexpr int kResiduals = 1;
  static constexpr int kParameters = Model::kParameters;
  double response;
  const double* predictors;

  template <class T>
  void operator()(const T* b, T* r) const {
    r[0] = Model::Predict(b, predictors) - T(response);
  }
};

template <class Model>
std::vector<Residual<Model>> Residuals(const Problem& problem) {
  std::vector<Residual<Model>> residuals;
  const auto stride = 1 + static_cast<std::size_t>(problem.num_predictors);
  for (std::size_t i = 0; i < problem.rows.size(); i += stride) {
    double response = problem.rows[i];
    if constexpr (requires { Model::Response(response); }) response = Model::Response(response);
    residuals.push_back({response, &problem.rows[i + 1]});
  }
  return residuals;
}

// Calls visit.operator()<Model>(problem) for each of the 27 problems.
template <class Visitor>
void ForEachProblem(const Visitor& visit) {
  visit.template operator()<Saturation>(kMisra1a);
  visit.template operator()<Chwirut>(kChwirut2);
  visit.template operator()<Chwirut>(kChwirut1);
  visit.template operator()<ThreeDecays>(kLanczos3);
  visit.template operator()<TwoPeaks>(kGauss1);
  visit.template operator()<TwoPeaks>(kGauss2);
  visit.template operator()<Power>(kDanWood);
  visit.template operator()<Misra1bModel>(kMisra1b);
  visit.template operator()<QuadraticByQuadratic>(kKirby2);
  visit.template operator()<CubicByCubic>(kHahn1);
  visit.template operator()<NelsonModel>(kNelson);
  visit.template operator()<TwoDecays>(kMGH17);
  visit.template operator()<ThreeDecays>(kLanczos1);
  visit.template operator()<ThreeDecays>(kLanczos2);
  visit.template operator()<TwoPeaks>(kGauss3);
  visit.template operator()<Misra1cModel>(kMisra1c);
  visit.template operator()<Misra1dModel>(kMisra1d);
  visit.template operator()<RoszmanModel>(kRoszman1);
  visit.template operator()<Cycles>(kENSO);
  visit.template operator()<Mgh09Model>(kMGH09);
  visit.template operator()<CubicByCubic>(kThurber);
  visit.template operator()<Saturation>(kBoxBOD);
  visit.template operator()<Logistic>(kRat42);
  visit.template operator()<Mgh10Model>(kMGH10);
  visit.template operator()<Bell>(kEckerle4);
  visit.template operator()<GeneralizedLogistic>(kRat43);
  visit.template operator()<ShiftedPower>(kBennett5);
}

}  // namespace vesta::nist
