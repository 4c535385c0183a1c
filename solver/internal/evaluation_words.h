// SPDX-License-Identifier: Apache-2.0
// Numbers of an evaluation that went wrong, in words for messages.
#pragma once

#include <span>
#include <string>

#include "kernels/core/span.h"
#include "solver/internal/unwritten.h"

namespace vesta {

// "is nan", "is inf", "was not written"; what is finite: its value.
std::string ValueInWords(double value);
inline std::string ValueInWords(float value) {
  return ValueInWords(IsUnwritten(value) ? Unwritten<double>() : static_cast<double>(value));
}

// "the loss of residual block 3 is nan for a square of 2", rho being the loss's value.
std::string LossInWords(Index block, double square, double rho);

// "[1, 2.5, 3]"; of long ones the first dozen, and how many there are.
std::string NumbersInWords(std::span<const double> values);

}  // namespace vesta
