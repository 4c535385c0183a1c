// SPDX-License-Identifier: Apache-2.0
// Evaluates a program for many rows of inputs, with SIMD instructions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cpu_dispatch.h"
#include "problems/program/program.h"

namespace vesta::program {

// Rows are evaluated in chunks of this size. It is large enough that decoding an instruction costs little, and small
// enough that the values of a chunk stay in the cache.
inline constexpr int kChunk = 64;

// One operation on the kChunk values of each operand. Operands and results are numbers of arrays.
struct Step {
  Operation operation;
  int result, a, b, c;
};

// A program whose results are assigned to arrays, which are reused after the last use of a result. Arrays are numbered:
// first the num_inputs inputs, then the outputs, then the constants, then the others.
class ProgramPlan {
 public:
  explicit ProgramPlan(const Program& program);
  int num_inputs() const { return num_inputs_; }
  int num_outputs() const { return num_outputs_; }
  const std::vector<double>& constants() const { return constants_; }
  int num_arrays() const { return num_arrays_; }
  const std::vector<Step>& steps() const { return steps_; }

 private:
  int num_inputs_, num_outputs_, num_arrays_ = 0;
  std::vector<double> constants_;
  std::vector<Step> steps_;
};

// Runs the steps. arrays[i]: kChunk values, aligned to 64 bytes.
using RunSteps = void(std::span<const Step> steps, double* const* arrays);
// The function for an instruction set that the CPU supports.
RunSteps* RunStepsFor(Isa isa);

}  // namespace vesta::program
