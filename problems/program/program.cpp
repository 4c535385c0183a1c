// SPDX-License-Identifier: Apache-2.0
#include "problems/program/program.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <utility>

#include "kernels/core/error.h"
#include "problems/program/operation_formula.h"

namespace vesta::program {

void Check(const Program& program) {
  const auto require = [](bool valid, int position) {
    if (!valid) throw Error(kBadArgument, fmt::format("instruction {} of the program is not valid", position));
  };
  const int count = static_cast<int>(program.instructions.size());
  for (int i = 0; i < count; ++i) {
    const Instruction& instruction = program.instructions[static_cast<std::size_t>(i)];
    require(static_cast<int>(instruction.operation) < kNumOperations, i);
    if (instruction.operation == Operation::kInput) {
      require(instruction.a >= 0 && instruction.a < program.num_inputs, i);
    }
    ForEachOperand(instruction, [&](int operand) { require(operand >= 0 && operand < i, i); });
  }
  for (const int output : program.outputs) {
    if (output < 0 || output >= count) throw Error(kBadArgument, "an output of the program is not an instruction");
  }
}

std::size_t ProgramBuilder::Hash::operator()(const Instruction& instruction) const {
  std::uint64_t hash = static_cast<std::uint64_t>(instruction.operation);
  for (const std::uint64_t part :
       {static_cast<std::uint64_t>(instruction.a), static_cast<std::uint64_t>(instruction.b),
        static_cast<std::uint64_t>(instruction.c), std::bit_cast<std::uint64_t>(instruction.value)}) {
    hash = (hash ^ part) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 29;
  }
  return hash;
}

int ProgramBuilder::Append(const Instruction& instruction) {
  // A NaN differs from itself, and 0 equals -0: such constants are not merged.
  const bool merge = instruction.value != 0 || !std::signbit(instruction.value);
  if (merge) {
    if (const auto found = positions_.find(instruction); found != positions_.end()) return found->second;
  }
  const int position = static_cast<int>(program_.instructions.size());
  program_.instructions.push_back(instruction);
  if (merge) positions_.emplace(instruction, position);
  return position;
}

bool ProgramBuilder::IsConstant(int position, double value) const {
  return at(position).operation == Operation::kConstant && at(position).value == value;
}

int ProgramBuilder::Simplified(const Instruction& instruction) {
  using enum Operation;
  const auto& [operation, a, b, c, value] = instruction;
  bool folds = true;
  ForEachOperand(instruction, [&](int operand) { folds = folds && at(operand).operation == kConstant; });
  if (folds) {
    double result = 0;
    const double x = at(a).value, y = b < 0 ? 0 : at(b).value, z = c < 0 ? 0 : at(c).value;
    WithFormula<double>(operation, [&](const auto& formula) { result = formula(x, y, z); });
    return Constant(result);
  }
  switch (operation) {
    case kNegate:
      return at(a).operation == kNegate ? at(a).a : -1;
    case kAdd:
      return IsConstant(a, 0) ? b : IsConstant(b, 0) ? a : -1;
    case kSubtract:
      return IsConstant(b, 0) ? a : IsConstant(a, 0) ? Add(kNegate, b) : -1;
    case kMultiply:
      if (IsConstant(a, 1)) return b;
      if (IsConstant(b, 1)) return a;
      if (IsConstant(a, -1)) return Add(kNegate, b);
      return IsConstant(b, -1) ? Add(kNegate, a) : -1;
    case kDivide:
      return IsConstant(b, 1) ? a : -1;
    case kPow:
      if (IsConstant(b, 1)) return a;
      if (IsConstant(b, 2)) return Add(kMultiply, a, a);
      if (IsConstant(b, 0.5)) return Add(kSqrt, a);
      return IsConstant(b, -1) ? Add(kDivide, Constant(1), a) : -1;
    case kSelect:
      if (at(a).operation == kConstant) return at(a).value != 0 ? b : c;
      return b == c ? b : -1;
    default:
      return -1;
  }
}

int ProgramBuilder::Add(Operation operation, int a, int b, int c) {
  Instruction instruction{.operation = operation, .a = a, .b = b, .c = c};
  if ((operation == Operation::kAdd || operation == Operation::kMultiply) && a > b) {
    std::swap(instruction.a, instruction.b);
  }
  const int simplified = Simplified(instruction);
  return simplified >= 0 ? simplified : Append(instruction);
}

Program ProgramBuilder::Finish(const std::vector<int>& outputs) const {
  std::vector<bool> needed(program_.instructions.size());
  for (const int output : outputs) needed[static_cast<std::size_t>(output)] = true;
  for (std::size_t i = needed.size(); i-- > 0;) {
    if (!needed[i]) continue;
    ForEachOperand(program_.instructions[i], [&](int operand) { needed[static_cast<std::size_t>(operand)] = true; });
  }
  Program result{.num_inputs = program_.num_inputs, .instructions = {}, .outputs = {}};
  std::vector<int> moved(needed.size(), -1);
  for (std::size_t i = 0; i < needed.size(); ++i) {
    if (!needed[i]) continue;
    Instruction instruction = program_.instructions[i];
    const int operands = NumOperands(instruction.operation);
    if (operands > 0) instruction.a = moved[static_cast<std::size_t>(instruction.a)];
    if (operands > 1) instruction.b = moved[static_cast<std::size_t>(instruction.b)];
    if (operands > 2) instruction.c = moved[static_cast<std::size_t>(instruction.c)];
    moved[i] = static_cast<int>(result.instructions.size());
    result.instructions.push_back(instruction);
  }
  for (const int output : outputs) result.outputs.push_back(moved[static_cast<std::size_t>(output)]);
  return result;
}

}  // namespace vesta::program
