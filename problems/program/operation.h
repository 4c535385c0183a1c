// SPDX-License-Identifier: Apache-2.0
// The operations of residual programs.
#pragma once

#include <cstdint>
#include <string_view>

namespace vesta::program {

// Numbers are doubles. Comparisons and logical operations give 1 for true and 0 for false.
enum class Operation : std::uint8_t {
  // Leaves.
  kInput,     // input number Instruction::a
  kConstant,  // Instruction::value
  // One operand.
  kNegate,
  kAbs,
  kSqrt,
  kNorm,  // like kSqrt, for sums of squares: the derivative at 0 is 0
  kExp,
  kExpm1,
  kLog,
  kLog1p,
  kSin,
  kCos,
  kTan,
  kAsin,
  kAcos,
  kAtan,
  kSinh,
  kCosh,
  kTanh,
  kFloor,
  kIsNan,
  kNot,
  // Two operands.
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kPow,
  kAtan2,  // a: y, b: x
  kMin,    // b if b < a, else a
  kMax,    // b if a < b, else a
  kLess,
  kLessEqual,
  kEqual,
  kAnd,
  // Three operands: b if a is not 0, else c.
  kSelect,
};

inline constexpr int kNumOperations = static_cast<int>(Operation::kSelect) + 1;

constexpr int NumOperands(Operation operation) {
  if (operation <= Operation::kConstant) return 0;
  if (operation <= Operation::kNot) return 1;
  return operation == Operation::kSelect ? 3 : 2;
}

// The operation with a name such as "add", as in the names above in lower case with underscores. Throws Error if there
// is none.
Operation OperationNamed(std::string_view name);

}  // namespace vesta::program
