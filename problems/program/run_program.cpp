// SPDX-License-Identifier: Apache-2.0
#include "problems/program/run_program.h"

#include <cstddef>

namespace vesta {

VESTA_DECLARE_PER_ISA(void CompiledRunSteps(std::span<const program::Step> steps, double* const* arrays);)

namespace program {

ProgramPlan::ProgramPlan(const Program& program)
    : num_inputs_(program.num_inputs), num_outputs_(static_cast<int>(program.outputs.size())) {
  Check(program);
  const std::size_t count = program.instructions.size();
  std::vector<std::size_t> last_use(count, 0);
  std::vector<int> array(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    const Instruction& instruction = program.instructions[i];
    ForEachOperand(instruction, [&](int operand) { last_use[static_cast<std::size_t>(operand)] = i; });
    if (instruction.operation == Operation::kInput) array[i] = instruction.a;
    if (instruction.operation == Operation::kConstant) {
      array[i] = num_inputs_ + num_outputs_ + static_cast<int>(constants_.size());
      constants_.push_back(instruction.value);
    }
  }
  // Results that are outputs are computed in place. Leaves, and outputs that occur twice, are copied below.
  for (std::size_t o = 0; o < program.outputs.size(); ++o) {
    int& assigned = array[static_cast<std::size_t>(program.outputs[o])];
    if (assigned < 0) assigned = num_inputs_ + static_cast<int>(o);
  }
  num_arrays_ = num_inputs_ + num_outputs_ + static_cast<int>(constants_.size());
  const int first_reused = num_arrays_;
  std::vector<int> unused;
  for (std::size_t i = 0; i < count; ++i) {
    const Instruction& instruction = program.instructions[i];
    if (NumOperands(instruction.operation) == 0) continue;
    Step step{.operation = instruction.operation, .result = 0, .a = 0, .b = 0, .c = 0};
    int* to = &step.a;
    for (const int operand : {instruction.a, instruction.b, instruction.c}) {
      if (operand >= 0) *to = array[static_cast<std::size_t>(operand)];
      to = to == &step.a ? &step.b : &step.c;
    }
    // The result may take the place of an operand, because each row is read before it is written.
    ForEachOperand(instruction, [&](int operand) {
      const auto o = static_cast<std::size_t>(operand);
      if (last_use[o] != i || array[o] < first_reused) return;
      unused.push_back(array[o]);
      last_use[o] = count;  // an operand that occurs twice is released once
    });
    if (array[i] < 0) {
      if (unused.empty()) {
        array[i] = num_arrays_++;
      } else {
        array[i] = unused.back();
        unused.pop_back();
      }
    }
    step.result = array[i];
    steps_.push_back(step);
  }
  for (std::size_t o = 0; o < program.outputs.size(); ++o) {
    const int from = array[static_cast<std::size_t>(program.outputs[o])], to = num_inputs_ + static_cast<int>(o);
    if (from != to) steps_.push_back({.operation = Operation::kInput, .result = to, .a = from, .b = 0, .c = 0});
  }
}

RunSteps* RunStepsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledRunSteps); }

}  // namespace program
}  // namespace vesta
