// SPDX-License-Identifier: Apache-2.0
#include "problems/program/differentiate.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

namespace vesta::program {

namespace {

using enum Operation;

// Copies the instructions of a program into a builder, and adds derivatives. `at` maps positions of the program to
// positions of the builder; -1 stands for the number 0.
class Differentiator {
 public:
  Differentiator(const Program& program, int num_variables)
      : program_(program), num_variables_(num_variables), builder_(program.num_inputs) {
    for (const Instruction& instruction : program.instructions) copies_.push_back(Copy(instruction));
    // Operands that depend on a variable.
    for (const Instruction& instruction : program.instructions) {
      bool active = instruction.operation == kInput && instruction.a < num_variables_;
      ForEachOperand(instruction, [&](int operand) { active = active || active_[Position(operand)]; });
      active_.push_back(active);
    }
  }

  Derivatives Forward() {
    // Per instruction: the derivatives by the variables on which it depends.
    std::vector<std::map<int, int>> derivatives(program_.instructions.size());
    for (std::size_t i = 0; i < derivatives.size(); ++i) {
      if (!active_[i]) continue;
      const Instruction& instruction = program_.instructions[i];
      if (instruction.operation == kInput) {
        derivatives[i][instruction.a] = builder_.Constant(1);
      } else if (instruction.operation == kSelect) {
        derivatives[i] = OfSelect(instruction, derivatives);
      } else {
        VisitPartials(i, [&](int operand, int partial) {
          for (const auto& [variable, derivative] : derivatives[Position(operand)]) {
            AddTo(derivatives[i], variable, Times(partial, derivative));
          }
        });
      }
    }
    std::vector<std::map<int, int>> rows;
    rows.reserve(program_.outputs.size());
    for (const int output : program_.outputs) rows.push_back(derivatives[Position(output)]);
    return Finish(rows);
  }

  Derivatives Reverse() {
    std::vector<std::map<int, int>> rows;
    for (const int output : program_.outputs) {
      std::map<int, int> adjoints;  // derivatives of the output by instruction
      std::map<int, int> row;
      adjoints[output] = builder_.Constant(1);
      while (!adjoints.empty()) {
        const auto [position, adjoint] = *adjoints.rbegin();
        adjoints.erase(position);
        const Instruction& instruction = program_.instructions[Position(position)];
        if (!active_[Position(position)]) continue;
        if (instruction.operation == kInput) {
          AddTo(row, instruction.a, adjoint);
        } else {
          VisitPartials(Position(position), [&, value = adjoint](int operand, int partial) {
            AddTo(adjoints, operand, Times(partial, value));
          });
        }
      }
      rows.push_back(std::move(row));
    }
    return Finish(rows);
  }

  bool has_select() const {
    return std::ranges::any_of(program_.instructions, [](const Instruction& i) { return i.operation == kSelect; });
  }

 private:
  static std::size_t Position(int position) { return static_cast<std::size_t>(position); }
  int At(int position) const { return position < 0 ? -1 : copies_[Position(position)]; }
  int Copy(const Instruction& instruction) {
    if (instruction.operation == kInput) return builder_.Input(instruction.a);
    if (instruction.operation == kConstant) return builder_.Constant(instruction.value);
    return builder_.Add(instruction.operation, At(instruction.a), At(instruction.b), At(instruction.c));
  }
  int Times(int a, int b) { return builder_.Add(kMultiply, a, b); }
  int Quotient(int a, int b) { return builder_.Add(kDivide, a, b); }
  int Negative(int a) { return builder_.Add(kNegate, a); }
  int Number(double value) { return builder_.Constant(value); }
  void AddTo(std::map<int, int>& sums, int key, int term) {
    const auto [entry, added] = sums.emplace(key, term);
    if (!added) entry->second = builder_.Add(kAdd, entry->second, term);
  }

  std::map<int, int> OfSelect(const Instruction& select, const std::vector<std::map<int, int>>& derivatives) {
    std::map<int, int> result;
    const auto& first = derivatives[Position(select.b)];
    const auto& second = derivatives[Position(select.c)];
    const int zero = Number(0);
    const auto value_or_zero = [&](const std::map<int, int>& values, int variable) {
      const auto found = values.find(variable);
      return found == values.end() ? zero : found->second;
    };
    for (const auto* of : {&first, &second}) {
      for (const auto& [variable, derivative] : *of) {
        result[variable] =
            builder_.Add(kSelect, At(select.a), value_or_zero(first, variable), value_or_zero(second, variable));
      }
    }
    return result;
  }

  // Calls visit(operand, partial derivative by the operand) for the active operands of instruction i. Not for leaves
  // and kSelect.
  template <class Visit>
  void VisitPartials(std::size_t i, const Visit& visit) {
    const Instruction& instruction = program_.instructions[i];
    const int y = copies_[i], a = At(instruction.a), b = At(instruction.b);
    const auto first = [&](const auto& partial) {
      if (active_[Position(instruction.a)]) visit(instruction.a, partial());
    };
    const auto second = [&](const auto& partial) {
      if (active_[Position(instruction.b)]) visit(instruction.b, partial());
    };
    const auto one = [&] { return Number(1); };
    const auto minus_one = [&] { return Number(-1); };
    const auto one_where = [&](int condition) { return builder_.Add(kSelect, condition, Number(1), Number(0)); };
    const auto ratio_or_zero = [&](int numerator) {
      return builder_.Add(kSelect, builder_.Add(kEqual, y, Number(0)), Number(0), Quotient(numerator, y));
    };
    switch (instruction.operation) {
      case kInput:
      case kConstant:
      case kSelect:
      case kFloor:
      case kIsNan:
      case kNot:
      case kLess:
      case kLessEqual:
      case kEqual:
      case kAnd:
        return;
      case kNegate:
        return first(minus_one);
      case kAbs:
        return first([&] { return builder_.Add(kSelect, builder_.Add(kLess, a, Number(0)), Number(-1), Number(1)); });
      case kSqrt:
        return first([&] { return Quotient(Number(0.5), y); });
      case kNorm:
        return first([&] { return ratio_or_zero(Number(0.5)); });
      case kExp:
        return first([&] { return y; });
      case kExpm1:
        return first([&] { return builder_.Add(kAdd, y, Number(1)); });
      case kLog:
        return first([&] { return Quotient(Number(1), a); });
      case kLog1p:
        return first([&] { return Quotient(Number(1), builder_.Add(kAdd, a, Number(1))); });
      case kSin:
        return first([&] { return builder_.Add(kCos, a); });
      case kCos:
        return first([&] { return Negative(builder_.Add(kSin, a)); });
      case kTan:
        return first([&] { return builder_.Add(kAdd, Times(y, y), Number(1)); });
      case kAsin:
        return first([&] { return Quotient(Number(1), Cathetus(a)); });
      case kAcos:
        return first([&] { return Quotient(Number(-1), Cathetus(a)); });
      case kAtan:
        return first([&] { return Quotient(Number(1), builder_.Add(kAdd, Times(a, a), Number(1))); });
      case kSinh:
        return first([&] { return builder_.Add(kCosh, a); });
      case kCosh:
        return first([&] { return builder_.Add(kSinh, a); });
      case kTanh:
        return first([&] { return builder_.Add(kSubtract, Number(1), Times(y, y)); });
      case kAdd:
        return first(one), second(one);
      case kSubtract:
        return first(one), second(minus_one);
      case kMultiply:
        return first([&] { return b; }), second([&] { return a; });
      case kDivide: {
        const int reciprocal = Quotient(Number(1), b);
        return first([&] { return reciprocal; }), second([&] { return Negative(Times(y, reciprocal)); });
      }
      case kPow:
        first([&] { return Times(b, builder_.Add(kPow, a, builder_.Add(kSubtract, b, Number(1)))); });
        // a^b log(a); 0 at a = 0, where it is the limit for b > 0.
        return second([&] {
          const int product = Times(y, builder_.Add(kLog, a));
          return builder_.Add(kSelect, builder_.Add(kEqual, a, Number(0)), Number(0), product);
        });
      case kAtan2: {
        const int squared = builder_.Add(kAdd, Times(a, a), Times(b, b));
        return first([&] { return Quotient(b, squared); }), second([&] { return Negative(Quotient(a, squared)); });
      }
      case kMin:
      case kMax: {
        const bool min = instruction.operation == kMin;
        const int takes_b = min ? builder_.Add(kLess, b, a) : builder_.Add(kLess, a, b);
        return first([&] { return one_where(builder_.Add(kNot, takes_b)); }),
               second([&] { return one_where(takes_b); });
      }
    }
  }
  // sqrt(1 - a^2)
  int Cathetus(int a) { return builder_.Add(kSqrt, builder_.Add(kSubtract, Number(1), Times(a, a))); }

  Derivatives Finish(const std::vector<std::map<int, int>>& rows) {
    std::vector<int> outputs;
    for (const int output : program_.outputs) outputs.push_back(At(output));
    Derivatives result;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      for (const auto& [variable, derivative] : rows[r]) {
        result.entries.push_back({static_cast<int>(r), variable});
        outputs.push_back(derivative);
      }
    }
    result.program = builder_.Finish(outputs);
    return result;
  }

  const Program& program_;
  int num_variables_;
  ProgramBuilder builder_;
  std::vector<int> copies_;
  std::vector<bool> active_;
};

}  // namespace

Derivatives Differentiate(const Program& program, int num_variables) {
  Check(program);
  Differentiator forward(program, num_variables);
  Derivatives result = forward.Forward();
  if (forward.has_select()) return result;
  Derivatives reverse = Differentiator(program, num_variables).Reverse();
  const bool shorter = reverse.program.instructions.size() < result.program.instructions.size();
  return shorter ? std::move(reverse) : std::move(result);
}

}  // namespace vesta::program
