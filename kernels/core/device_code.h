// SPDX-License-Identifier: Apache-2.0
// Whether a program has code that the GPU can run.
#pragma once

#include <string>

namespace vesta::device {

// Empty where the GPU in use can run this program's kernels, else CUDA's reason: no machine code for it, or PTX that is
// too new for the driver.
std::string WhyNoCodeRuns();

// What a user is told then, and can do. capability: 10 major + minor.
inline std::string NoCodeWords(const std::string& gpu, int capability, const std::string& reason) {
  return gpu + " has compute capability " + std::to_string(capability / 10) + "." + std::to_string(capability % 10) +
         ", for which this program has no code; build it with CMAKE_CUDA_ARCHITECTURES=" + std::to_string(capability) +
         " (CUDA: " + reason + ")";
}

}  // namespace vesta::device
