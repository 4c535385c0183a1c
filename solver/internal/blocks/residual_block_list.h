// SPDX-License-Identifier: Apache-2.0
// Which residual blocks there are: thousands to millions of them, in three arrays.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace vesta {

// A residual block: how many residuals, of which parameter blocks.
struct ResidualBlock {
  int num_residuals = 0;
  std::span<const int> parameters;
};

class ResidualBlockList {
 public:
  std::size_t size() const { return num_residuals_.size(); }
  // Parameters of all residual blocks together.
  std::size_t num_arguments() const { return parameters_.size(); }
  ResidualBlock operator[](std::size_t k) const {
    return {num_residuals_[k], std::span(parameters_).subspan(first_[k], first_[k + 1] - first_[k])};
  }
  void Reserve(std::size_t count) {
    num_residuals_.reserve(count);
    first_.reserve(count + 1);
  }
  void Add(const ResidualBlock& block) {
    parameters_.insert(parameters_.end(), block.parameters.begin(), block.parameters.end());
    first_.push_back(parameters_.size());
    num_residuals_.push_back(block.num_residuals);
  }

 private:
  std::vector<int> num_residuals_;
  std::vector<std::size_t> first_{0};  // of each block's parameters; the end of the last
  std::vector<int> parameters_;
};

}  // namespace vesta
