// SPDX-License-Identifier: Apache-2.0
// The value of an operation, for double and DoubleLanes.
#pragma once

#include <cmath>

#include "kernels/math/isa.h"
#include "kernels/math/scalar.h"
#include "problems/program/operation.h"

namespace vesta {
inline namespace VESTA_ISA {

// Calls visit(formula), where formula(a, b, c) computes the operation from its operands. Not for leaves. T: double or
// DoubleLanes.
template <class T, class Visit>
void WithFormula(program::Operation operation, const Visit& visit) {
  using enum program::Operation;
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::expm1, std::floor,
      std::log, std::log1p, std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  const auto unary = [&](const auto& f) { visit([f](const T& a, const T&, const T&) { return T(f(a)); }); };
  const auto binary = [&](const auto& f) { visit([f](const T& a, const T& b, const T&) { return T(f(a, b)); }); };
  const auto truth = [](const auto& mask) { return Select(mask, T(1.0), T(0.0)); };
  switch (operation) {
    case kInput:
    case kConstant:
      return;
    case kNegate:
      return unary([](const T& a) { return -a; });
    case kAbs:
      return unary([](const T& a) { return abs(a); });
    case kSqrt:
    case kNorm:
      return unary([](const T& a) { return sqrt(a); });
    case kExp:
      return unary([](const T& a) { return exp(a); });
    case kExpm1:
      return unary([](const T& a) { return expm1(a); });
    case kLog:
      return unary([](const T& a) { return log(a); });
    case kLog1p:
      return unary([](const T& a) { return log1p(a); });
    case kSin:
      return unary([](const T& a) { return sin(a); });
    case kCos:
      return unary([](const T& a) { return cos(a); });
    case kTan:
      return unary([](const T& a) { return tan(a); });
    case kAsin:
      return unary([](const T& a) { return asin(a); });
    case kAcos:
      return unary([](const T& a) { return acos(a); });
    case kAtan:
      return unary([](const T& a) { return atan(a); });
    case kSinh:
      return unary([](const T& a) { return sinh(a); });
    case kCosh:
      return unary([](const T& a) { return cosh(a); });
    case kTanh:
      return unary([](const T& a) { return tanh(a); });
    case kFloor:
      return unary([](const T& a) { return floor(a); });
    case kIsNan:
      return unary([&](const T& a) { return truth(a != a); });
    case kNot:
      return unary([&](const T& a) { return truth(a == T(0.0)); });
    case kAdd:
      return binary([](const T& a, const T& b) { return a + b; });
    case kSubtract:
      return binary([](const T& a, const T& b) { return a - b; });
    case kMultiply:
      return binary([](const T& a, const T& b) { return a * b; });
    case kDivide:
      return binary([](const T& a, const T& b) { return a / b; });
    case kPow:
      return binary([](const T& a, const T& b) { return pow(a, b); });
    case kAtan2:
      return binary([](const T& a, const T& b) { return atan2(a, b); });
    case kMin:
      return binary([](const T& a, const T& b) { return Select(b < a, b, a); });
    case kMax:
      return binary([](const T& a, const T& b) { return Select(a < b, b, a); });
    case kLess:
      return binary([&](const T& a, const T& b) { return truth(a < b); });
    case kLessEqual:
      return binary([&](const T& a, const T& b) { return truth(a <= b); });
    case kEqual:
      return binary([&](const T& a, const T& b) { return truth(a == b); });
    case kAnd:
      return binary([&](const T& a, const T& b) { return Select(a == T(0.0), T(0.0), truth(b != T(0.0))); });
    case kSelect:
      return visit([](const T& a, const T& b, const T& c) { return Select(a != T(0.0), b, c); });
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta
