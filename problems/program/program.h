// SPDX-License-Identifier: Apache-2.0
// Residuals as a program: a list of operations on numbers. A program is evaluated for many rows of inputs at once
// (run_program.h), and differentiated symbolically (differentiate.h). The Python package makes programs from functions.
#pragma once

#include <cstddef>
#include <unordered_map>
#include <vector>

#include "problems/program/operation.h"

namespace vesta::program {

// The operands a, b, c are positions of earlier instructions; -1 if the operation has fewer. For kInput, a is the
// number of the input.
struct Instruction {
  Operation operation = Operation::kConstant;
  int a = -1, b = -1, c = -1;
  double value = 0;
  bool operator==(const Instruction&) const = default;
};

struct Program {
  int num_inputs = 0;
  std::vector<Instruction> instructions;
  std::vector<int> outputs;  // positions of instructions
};

// Throws Error if an operand or output does not refer to an earlier instruction, or an input is out of range.
void Check(const Program& program);

// Calls visit(operand) for each operand of an instruction that is not a leaf.
template <class Visit>
void ForEachOperand(const Instruction& instruction, const Visit& visit) {
  const int count = NumOperands(instruction.operation);
  if (count > 0) visit(instruction.a);
  if (count > 1) visit(instruction.b);
  if (count > 2) visit(instruction.c);
}

// Appends instructions to a program. An instruction that the program already contains is not repeated. Operations on
// constants are evaluated, and operations such as x + 0 and 1 * x are left out.
class ProgramBuilder {
 public:
  explicit ProgramBuilder(int num_inputs) { program_.num_inputs = num_inputs; }
  int Input(int input) { return Append({.operation = Operation::kInput, .a = input}); }
  int Constant(double value) { return Append({.operation = Operation::kConstant, .value = value}); }
  int Add(Operation operation, int a, int b = -1, int c = -1);
  const Instruction& at(int position) const { return program_.instructions[static_cast<std::size_t>(position)]; }
  // The program with these outputs, without instructions that no output needs.
  Program Finish(const std::vector<int>& outputs) const;

 private:
  struct Hash {
    std::size_t operator()(const Instruction& instruction) const;
  };
  bool IsConstant(int position, double value) const;
  // The position of a simpler expression with the same value, or -1.
  int Simplified(const Instruction& instruction);
  int Append(const Instruction& instruction);

  Program program_;
  std::unordered_map<Instruction, int, Hash> positions_;
};

}  // namespace vesta::program
