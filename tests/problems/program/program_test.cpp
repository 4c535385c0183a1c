// SPDX-License-Identifier: Apache-2.0
#include "problems/program/program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/error.h"
#include "kernels/math/derivatives.h"
#include "kernels/math/dual.h"
#include "problems/program/differentiate.h"
#include "problems/program/run_program.h"

namespace vesta::program {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The outputs of a program for kChunk rows: outputs[o * kChunk + row]. inputs: the same order.
std::vector<double> ValuesOf(const Program& program, const std::vector<double>& inputs, Isa isa = Isa::kBaseline) {
  const ProgramPlan plan(program);
  Buffer<double, Host> memory(Index{plan.num_arrays()} * kChunk);
  std::vector<double*> arrays(static_cast<std::size_t>(plan.num_arrays()));
  for (std::size_t i = 0; i < arrays.size(); ++i) arrays[i] = memory.data() + i * kChunk;
  std::copy(inputs.begin(), inputs.end(), memory.data());
  for (std::size_t c = 0; c < plan.constants().size(); ++c) {
    std::fill_n(arrays[static_cast<std::size_t>(plan.num_inputs() + plan.num_outputs()) + c], kChunk,
                plan.constants()[c]);
  }
  RunStepsFor(isa)(plan.steps(), arrays.data());
  const double* const outputs = memory.data() + Index{plan.num_inputs()} * kChunk;
  return {outputs, outputs + Index{plan.num_outputs()} * kChunk};
}

// Uses every operation with a derivative; T is double or a dual number.
template <class T>
std::vector<T> Reference(const T& x, const T& y, double d) {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::expm1, std::log,
      std::log1p, std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  return {sin(x) * cos(y) + tan(x) / y,
          asin(x) + acos(y) + atan(x * y),
          sinh(x) - cosh(y) + tanh(x),
          exp(x) * log(y) + expm1(y) + log1p(x),
          sqrt(x) + sqrt(x * x + y * y) + abs(x - y),
          pow(x, y) + pow(x, T(2.5)) + atan2(y, x),
          (x < y ? x * d : y / d) + (y < x ? y : x) + (x < y ? y : x),
          -x};
}

struct Recorded {
  ProgramBuilder builder{3};
  int x = builder.Input(0), y = builder.Input(1), d = builder.Input(2);
  int Of(Operation operation, int a, int b = -1, int c = -1) { return builder.Add(operation, a, b, c); }

  Program Make(bool with_select) {
    using enum Operation;
    const int squares = Of(kAdd, Of(kMultiply, x, x), Of(kMultiply, y, y));
    const int less = Of(kLess, x, y);
    std::vector<int> outputs = {
        Of(kAdd, Of(kMultiply, Of(kSin, x), Of(kCos, y)), Of(kDivide, Of(kTan, x), y)),
        Of(kAdd, Of(kAdd, Of(kAsin, x), Of(kAcos, y)), Of(kAtan, Of(kMultiply, x, y))),
        Of(kAdd, Of(kSubtract, Of(kSinh, x), Of(kCosh, y)), Of(kTanh, x)),
        Of(kAdd, Of(kAdd, Of(kMultiply, Of(kExp, x), Of(kLog, y)), Of(kExpm1, y)), Of(kLog1p, x)),
        Of(kAdd, Of(kAdd, Of(kSqrt, x), Of(kNorm, squares)), Of(kAbs, Of(kSubtract, x, y))),
        Of(kAdd, Of(kAdd, Of(kPow, x, y), Of(kPow, x, builder.Constant(2.5))), Of(kAtan2, y, x))};
    if (with_select) {
      outputs.push_back(Of(kAdd, Of(kAdd, Of(kSelect, less, Of(kMultiply, x, d), Of(kDivide, y, d)), Of(kMin, x, y)),
                           Of(kMax, x, y)));
      outputs.push_back(Of(kNegate, x));
    }
    return builder.Finish(outputs);
  }
};

std::vector<double> RandomInputs() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  std::vector<double> inputs(3 * kChunk);
  for (double& value : inputs) value = uniform(random);
  return inputs;
}

// Forward accumulation if the program contains kSelect, else the shorter of both.
TEST(ProgramTest, DerivativesAreThoseOfDualNumbers) {
  using D = Dual<double, 2>;
  const std::vector<double> inputs = RandomInputs();
  for (const bool with_select : {false, true}) {
    const Program program = Recorded().Make(with_select);
    const Derivatives derivatives = Differentiate(program, 2);
    for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
      if (!IsaAvailable(isa)) continue;
      const std::vector<double> values = ValuesOf(derivatives.program, inputs, isa);
      for (std::size_t row = 0; row < kChunk; ++row) {
        const std::vector<D> expected =
            Reference(D(inputs[row], D::Derivative::Unit(0)), D(inputs[kChunk + row], D::Derivative::Unit(1)),
                      inputs[2 * kChunk + row]);
        for (std::size_t o = 0; o < program.outputs.size(); ++o) {
          EXPECT_NEAR(values[o * kChunk + row], expected[o].a, 1e-14) << o;
        }
        std::size_t at = program.outputs.size();
        for (const JacobianEntry& entry : derivatives.entries) {
          const double derivative = expected[static_cast<std::size_t>(entry.output)].v[entry.variable];
          EXPECT_NEAR(values[at++ * kChunk + row], derivative, 1e-13 * (1 + std::abs(derivative)))
              << entry.output << ", " << entry.variable;
        }
      }
    }
  }
}

TEST(ProgramTest, EntriesThatAreAlwaysZeroAreLeftOut) {
  ProgramBuilder builder(3);
  const int x = builder.Input(0), y = builder.Input(1), d = builder.Input(2);
  const Program program = builder.Finish(
      {builder.Add(Operation::kMultiply, x, d), builder.Add(Operation::kMultiply, y, y), builder.Constant(2)});
  const Derivatives derivatives = Differentiate(program, 2);
  ASSERT_EQ(derivatives.entries.size(), 2U);
  EXPECT_EQ(derivatives.entries[0].output, 0);
  EXPECT_EQ(derivatives.entries[0].variable, 0);
  EXPECT_EQ(derivatives.entries[1].output, 1);
  EXPECT_EQ(derivatives.entries[1].variable, 1);
}

// Of eight squared sums with shared terms, reverse accumulation needs fewer operations for one output, and forward
// accumulation for one variable.
TEST(ProgramTest, TheShorterAccumulationIsUsed) {
  ProgramBuilder builder(8);
  int product = builder.Input(0);
  for (int i = 1; i < 8; ++i) product = builder.Add(Operation::kMultiply, product, builder.Input(i));
  const Derivatives derivatives = Differentiate(builder.Finish({product}), 8);
  EXPECT_EQ(derivatives.entries.size(), 8U);
  // 8 inputs, 7 products, at most two products per derivative; forward accumulation needs about 8 * 7 / 2.
  EXPECT_LE(derivatives.program.instructions.size(), 8U + 7U + 13U);
}

TEST(ProgramTest, TheValueNotSelectedHasNoInfluence) {
  ProgramBuilder builder(1);
  const int x = builder.Input(0), zero = builder.Constant(0);
  const int root = builder.Add(Operation::kSqrt, x);
  const Program program =
      builder.Finish({builder.Add(Operation::kSelect, builder.Add(Operation::kLess, zero, x), root, x)});
  const Derivatives derivatives = Differentiate(program, 1);
  const std::vector<double> values = ValuesOf(derivatives.program, std::vector<double>(kChunk, -4.0));
  EXPECT_EQ(values[0], -4);
  EXPECT_EQ(values[kChunk], 1);
}

TEST(ProgramTest, TheDerivativeOfANormAtZeroIsZero) {
  ProgramBuilder builder(1);
  const int x = builder.Input(0);
  const Program program = builder.Finish({builder.Add(Operation::kNorm, builder.Add(Operation::kMultiply, x, x))});
  const std::vector<double> values = ValuesOf(Differentiate(program, 1).program, std::vector<double>(kChunk, 0.0));
  EXPECT_EQ(values[0], 0);
  EXPECT_EQ(values[kChunk], 0);
}

TEST(ProgramTest, LogicalOperations) {
  using enum Operation;
  ProgramBuilder builder(2);
  const int a = builder.Input(0), b = builder.Input(1);
  const Program program =
      builder.Finish({builder.Add(kLess, a, b), builder.Add(kLessEqual, a, b), builder.Add(kEqual, a, b),
                      builder.Add(kAnd, a, b), builder.Add(kNot, a), builder.Add(kIsNan, a), builder.Add(kFloor, b)});
  const double pairs[][2] = {{0, 1.5}, {2, 2}, {3, -1.5}, {kNaN, 1}};
  const double expected[][7] = {
      {1, 1, 0, 0, 1, 0, 1}, {0, 1, 1, 1, 0, 0, 2}, {0, 0, 0, 1, 0, 0, -2}, {0, 0, 0, 1, 0, 1, 1}};
  for (int k = 0; k < 4; ++k) {
    std::vector<double> inputs(2 * kChunk, pairs[k][0]);
    std::fill(inputs.begin() + kChunk, inputs.end(), pairs[k][1]);
    const std::vector<double> values = ValuesOf(program, inputs);
    for (std::size_t o = 0; o < 7; ++o) EXPECT_EQ(values[o * kChunk], expected[k][o]) << k << ", " << o;
  }
}

TEST(ProgramTest, RepeatedAndTrivialOperationsAreLeftOut) {
  using enum Operation;
  ProgramBuilder builder(2);
  const int x = builder.Input(0), y = builder.Input(1);
  EXPECT_EQ(builder.Add(kMultiply, x, y), builder.Add(kMultiply, y, x));
  EXPECT_EQ(builder.Add(kMultiply, x, builder.Constant(1)), x);
  EXPECT_EQ(builder.Add(kAdd, builder.Constant(0), y), y);
  EXPECT_EQ(builder.Add(kNegate, builder.Add(kNegate, x)), x);
  EXPECT_EQ(builder.at(builder.Add(kExp, builder.Constant(0))).value, 1);
  EXPECT_EQ(builder.at(builder.Add(kPow, x, builder.Constant(2))).operation, kMultiply);
  builder.Add(kSin, y);  // no output needs it
  EXPECT_EQ(builder.Finish({builder.Add(kCos, x)}).instructions.size(), 2U);
}

TEST(ProgramTest, InvalidProgramsAreRefused) {
  const auto expect_refused = [](const Program& program) {
    try {
      Check(program);
      ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), kBadArgument);
    }
  };
  expect_refused({.num_inputs = 1, .instructions = {{.operation = Operation::kInput, .a = 1}}, .outputs = {0}});
  expect_refused({.num_inputs = 1, .instructions = {{.operation = Operation::kSin, .a = 0}}, .outputs = {0}});
  expect_refused({.num_inputs = 1, .instructions = {{.operation = Operation::kInput, .a = 0}}, .outputs = {1}});
  EXPECT_THROW(OperationNamed("sinus"), Error);
  EXPECT_EQ(OperationNamed("select"), Operation::kSelect);
  EXPECT_EQ(OperationNamed("less_equal"), Operation::kLessEqual);
}

}  // namespace
}  // namespace vesta::program
